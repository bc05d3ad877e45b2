"""The exceptions of the package. The extension module raises them as well."""
import contextlib
import os
import re
import sys
import warnings

_PACKAGE = os.path.dirname(__file__) + os.sep


class Error(ValueError):
    """Input that cannot be used.

    kind: "usage" (an option or argument that makes no sense), "bad-input" (a file or array that
    cannot be used) or "io" (a file that cannot be read or written).
    place: the file with the line or byte, the options, or the argument.
    """

    def __init__(self, message, kind="usage", place=""):
        super().__init__(message)
        self.kind = kind
        self.place = place

    def __reduce__(self):  # exceptions of other processes arrive pickled
        return type(self), (str(self), self.kind, self.place)

    def __str__(self):
        return self.args[0]


class FileError(Error, OSError):
    """An Error of the kind "io"; also an OSError, as Python's own functions raise it."""


class Canceled(Exception):
    """The progress function has returned False."""


def _keyword(option):
    name = option[1].replace("-", "_")
    return name if option[2] is None else f"{name}={option[2]}"


def make_error(message, kind, place):
    """Returns the exception of the class that belongs to `kind`.

    The library mentions options in backticks, with values or without; here they are keywords.
    """
    message = re.sub("`([a-z-]+)(?: ([^`]*))?`", _keyword, message)
    return (FileError if kind == "io" else Error)(message, kind, place)


@contextlib.contextmanager
def as_file_error(name):
    """Lets an OSError of the block be a FileError of the file, whose name may be bytes."""
    try:
        yield
    except OSError as error:
        place = os.fsdecode(name)
        raise FileError(f"{place}: {error.strerror or error}", "io", place) from None


def left_out(what):
    """Warns of what a picture will not have, at the line of the caller outside of the package."""
    level, frame = 1, sys._getframe(1)
    while frame is not None and frame.f_code.co_filename.startswith(_PACKAGE):
        level, frame = level + 1, frame.f_back
    warnings.warn(what, stacklevel=level + 1)


def bad_argument(argument, reason):
    """Returns the Error of an argument whose type or shape makes no sense."""
    return Error(f"{argument}: {reason}", "usage", argument)


@contextlib.contextmanager
def renamed(**arguments):
    """Lets the errors of the block name the library's arguments as Python does."""
    try:
        yield
    except Error as error:
        name = arguments.get(error.place)
        if name is None:
            raise
        raise type(error)(name + str(error)[len(error.place):], error.kind, name) from None


def keywords(options):
    """The same for options, whose keywords have underscores for dashes."""
    return renamed(**{keyword.replace("_", "-"): keyword for keyword in options})
