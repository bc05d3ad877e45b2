"""The curve of sRGB (IEC 61966-2-1)."""
import numpy


def linear(srgb):
    """Returns linear radiance of values of sRGB in [0, 1]."""
    srgb = numpy.asarray(srgb, float)
    return numpy.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def srgb(radiance):
    """Returns values of sRGB in [0, 1] of linear radiance, which is cut off at 1."""
    radiance = numpy.clip(radiance, 0, 1)
    return numpy.where(radiance <= 0.0031308, 12.92 * radiance,
                       1.055 * radiance ** (1 / 2.4) - 0.055)


def bytes_of(values):
    """Returns values in [0, 1] as uint8."""
    return numpy.round(255 * numpy.asarray(values)).astype(numpy.uint8)
