"""Arguments as the library takes them: numbers, arrays, pictures, and options as text.

Types and shapes are checked here, because the library sees plain arrays of numbers. What the
numbers are is checked there.
"""
import numbers
import operator
import os

import numpy

from . import _core
from ._errors import bad_argument

_MOST_INT, _MOST_INDEX = 2**31 - 1, 2**32 - 1  # the largest int and index of the library


def path(value, argument):
    """Returns the bytes of a file name."""
    try:
        name = os.fsencode(value)
    except (TypeError, UnicodeEncodeError) as error:
        raise bad_argument(argument, f"it is no file name: {error}") from None
    if b"\0" in name:
        raise bad_argument(argument, "a file name has no zero byte")
    return name


def text(value, argument):
    """Returns the bytes of a str."""
    if not isinstance(value, str):
        raise bad_argument(argument, f"{value!r} is not a str")
    try:
        return value.encode(errors="surrogateescape")
    except UnicodeEncodeError as error:
        raise bad_argument(argument, f"it is no text: {error}") from None


def choice(value, argument, choices):
    """Returns a str that is one of `choices`."""
    if not isinstance(value, str) or value not in choices:
        raise bad_argument(argument, f"{value!r} is not one of {', '.join(choices)}")
    return value


def is_path(value):
    """Tells whether a value names a file; arrays and pictures do not."""
    return isinstance(value, (str, bytes, os.PathLike))


def number(value, argument):
    """Returns a number as a float that is rounded to float32; it may be infinite or NaN."""
    if isinstance(value, (str, bytes, bool)):
        raise bad_argument(argument, f"{value!r} is not a number")
    try:
        with numpy.errstate(over="ignore"):
            return float(numpy.float32(float(value)))
    except (TypeError, ValueError, OverflowError) as error:
        raise bad_argument(argument, f"it is not a number: {error}") from None


def index(value, argument):
    """Returns an int that fits into the library's."""
    try:
        value = operator.index(value)
    except TypeError as error:
        raise bad_argument(argument, f"it is not a whole number: {error}") from None
    if abs(value) > _MOST_INT:
        raise bad_argument(argument, "the number is too large")
    return value


def _array(values, argument, kinds, wanted):
    try:
        array = numpy.asarray(values)
    except (TypeError, ValueError, OverflowError) as error:
        raise bad_argument(argument, f"it is no array of {wanted}: {error}") from None
    if array.size == 0:
        raise bad_argument(argument, f"it is empty (shape {array.shape})")
    if array.dtype.kind not in kinds:
        raise bad_argument(argument, f"its elements are {array.dtype}, and {wanted} are needed")
    if max(array.shape, default=0) > _MOST_INT:
        raise bad_argument(argument, f"the shape {array.shape} is too large")
    return array


def _float32(array):
    # Always a copy: the caller's other threads cannot change it while the library reads it.
    with numpy.errstate(over="ignore"):
        return numpy.array(array, dtype=numpy.float32, order="C")


def rows(values, argument, columns):
    """Returns an array of shape (n, columns), float32."""
    array = _array(values, argument, "fiu", "numbers")
    if array.ndim != 2 or array.shape[1] != columns:
        raise bad_argument(argument, f"its shape is {array.shape}, and (n, {columns}) is needed")
    return _float32(array)


def column(values, argument):
    """Returns an array of shape (n,), float32."""
    array = _array(values, argument, "fiu", "numbers")
    if array.ndim != 1:
        raise bad_argument(argument, f"its shape is {array.shape}, and (n,) is needed")
    return _float32(array)


def indices(values, argument, columns, vertices):
    """Returns an array of shape (n, columns), uint32; `vertices` is the number of them."""
    array = _array(values, argument, "iu", "whole numbers")
    if array.ndim != 2 or array.shape[1] != columns:
        raise bad_argument(argument, f"its shape is {array.shape}, and (n, {columns}) is needed")
    # Indices that do not fit would wrap around to others.
    wrong = (array < 0) | (array > _MOST_INDEX)
    if wrong.any():
        row, column = numpy.argwhere(wrong)[0]
        raise bad_argument(argument, f"row {row} has the index {array[row, column]}, and there are "
                                     f"{vertices} vertices")
    return numpy.array(array, dtype=numpy.uint32, order="C")


def matrices(values, argument):
    """Returns an array of shape (n, 3, 4), float32, of affine matrices (n, 4, 4) or (n, 3, 4)."""
    array = _array(values, argument, "fiu", "numbers")
    if array.ndim != 3 or array.shape[1:] not in ((4, 4), (3, 4)):
        raise bad_argument(argument, f"its shape is {array.shape}, and (n, 4, 4) or (n, 3, 4) is "
                                     "needed")
    if array.shape[1] == 4 and (array[:, 3] != (0, 0, 0, 1)).any():
        raise bad_argument(argument, "the last row of a matrix is not 0, 0, 0, 1")
    return _float32(array[:, :3])


def vector(values, argument):
    """Returns three floats."""
    array = _array(values, argument, "fiu", "numbers")
    if array.shape != (3,):
        raise bad_argument(argument, f"its shape is {array.shape}, and (3,) is needed")
    return _float32(array).tolist()


def matrix(values, argument, shapes):
    """Returns the numbers of a matrix, row by row, and its shape."""
    array = _array(values, argument, "fiu", "numbers")
    if array.shape not in shapes:
        wanted = " or ".join(map(str, shapes))
        raise bad_argument(argument, f"its shape is {array.shape}, and {wanted} is needed")
    return numpy.asarray(array, dtype=float).ravel().tolist(), array.shape


def _is_single(value):
    try:
        return numpy.ndim(value) == 0
    except ValueError:  # rows of different lengths, which _array refuses by name
        return False


def color(value, argument):
    """Returns three floats; one number stands for three equal ones."""
    if _is_single(value):
        return [number(value, argument)] * 3
    return vector(value, argument)


def values(value, argument):
    """Returns one number, or several, as a list of floats; True is 1 and False is 0."""
    if isinstance(value, (bool, numpy.bool_)):
        return [float(value)]
    if _is_single(value):
        return [number(value, argument)]
    array = _array(value, argument, "fiu", "numbers")
    if array.ndim != 1:
        raise bad_argument(argument, f"its shape is {array.shape}, and (n,) is needed")
    return _float32(array).tolist()


def image(value, argument):
    """Returns an array of shape (height, width, 3), float32, of a Picture, an array or a file."""
    if is_path(value):
        return _core.read_image(path(value, argument))
    array = _array(value, argument, "fiu", "numbers")
    if array.dtype.kind != "f":
        raise bad_argument(argument, f"its elements are {array.dtype}, and floats are needed: "
                                     "linear radiance or reflectance, not an 8-bit picture")
    if array.ndim == 2:
        array = numpy.repeat(array[:, :, numpy.newaxis], 3, axis=2)
    if array.ndim != 3 or array.shape[2] != 3:
        raise bad_argument(argument, f"its shape is {array.shape}, and (height, width, 3) or "
                                     "(height, width) is needed")
    return _float32(array)


_SEPARATORS = {"size": "x", "strategies": " ", "integrators": " ", "material": ";"}  # else: ","


def _text(name, value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (str, bytes, os.PathLike)):
        return os.fsdecode(value)
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    if hasattr(value, "tolist"):  # arrays and scalars of numpy
        return _text(name, value.tolist())
    if not isinstance(value, (list, tuple, range)):
        raise TypeError(f"a {type(value).__name__} cannot be its value")
    if len(value) == 0:
        raise ValueError("it is empty; None leaves an option out")
    parts = [_text(name, part) for part in value]
    if name == "crop" and len(parts) == 4:
        return "{}x{}+{}+{}".format(*parts)
    return _SEPARATORS.get(name, ",").join(parts)


def options(keywords):
    """Returns the names and texts of options; those that are None are left out."""
    pairs = []
    for keyword, value in keywords.items():
        name = keyword.replace("_", "-")
        if value is None:
            continue
        try:
            pairs.append((os.fsencode(name), os.fsencode(_text(name, value))))
        except (TypeError, ValueError, OverflowError) as error:
            raise bad_argument(keyword, str(error)) from None
    return pairs
