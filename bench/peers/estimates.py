"""Tells the noise of pictures from their bias, by repeats that are independent of each other.

Pictures are lists of values of the same pixels. Their mean m over K repeats differs from the
reference R by bias and by what is left of the noise; the latter is known from how the repeats
differ among themselves, so that no program has to render until it has converged:

    noise^2 = mean over values of the variance s^2 of one repeat
    bias^2  = mean over values of (m - R)^2 - s^2 / K - (variance of R)

Both are unbiased estimates. That of bias^2 may be negative where there is little bias.
"""

import math
from array import array
from dataclasses import dataclass


@dataclass
class Estimate:
    """All relative to the mean of the reference, or its square."""
    mean: float            # difference of the means of all values
    mean_error: float | None  # standard error of it
    mse: float             # of one repeat, against the reference
    variance: float | None    # of one repeat about its own expectation
    bias2: float | None       # mean square of the difference of the expectations
    bias2_error: float | None  # standard error of it


def bias(estimate):
    """Returns (root mean square bias, whether that is only an upper limit of 95 %)."""
    limit = 2 * estimate.bias2_error
    if estimate.bias2 > limit:
        return math.sqrt(estimate.bias2), False
    return math.sqrt(max(estimate.bias2, 0) + limit), True


def visible(picture, mask):
    """Returns the values of the pixels that `mask` (one row of flags for each line) has."""
    values = array("f")
    for row, flags in zip(picture[2], mask):
        for x, flag in enumerate(flags):
            if flag:
                values.extend(row[3 * x:3 * x + 3])
    return values


def estimate(repeats, reference, reference_variance=0.0):
    """Compares K lists of values with the reference, whose values have this relative variance.

    With one repeat there is neither a variance nor a bias.
    """
    count, k = len(reference), len(repeats)
    level = math.fsum(reference) / count
    mse = sum(math.fsum((x - r) ** 2 for x, r in zip(values, reference))
              for values in repeats) / (k * count)
    means = [math.fsum(values) / count for values in repeats]
    mean = sum(means) / k
    result = Estimate(mean / level - 1, None, mse / level ** 2, None, None, None)
    if k < 2:
        return result
    variance, squares, squares2 = 0.0, 0.0, 0.0
    for reference_value, *values in zip(reference, *repeats):
        middle = sum(values) / k
        spread = sum((x - middle) ** 2 for x in values) / (k - 1)
        square = (middle - reference_value) ** 2 - spread / k
        variance += spread
        squares += square
        squares2 += square * square
    result.variance = variance / count / level ** 2
    result.bias2 = squares / count / level ** 2 - reference_variance
    # The channels of a pixel are not independent, so a third of the values count.
    result.bias2_error = math.sqrt(max(squares2 / count - (squares / count) ** 2, 0)
                                   / (count / 3)) / level ** 2
    # Samplers that share patterns between pixels have means that vary more than their pixels say.
    of_pixels = result.variance / (count / 3)
    of_means = sum((one - mean) ** 2 for one in means) / (k - 1) / level ** 2
    result.mean_error = math.sqrt(max(of_pixels, of_means) / k + reference_variance / (count / 3))
    return result
