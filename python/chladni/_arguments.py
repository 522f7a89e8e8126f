"""Arguments that NumPy is to use, refused with a reason where they are none."""

import operator
from numbers import Real

import numpy as np

from ._errors import InputError


def floats(values, name):
    """``values`` as an array of real numbers."""
    try:
        array = np.asarray(values)
        # Python's own numbers, such as fractions, are objects.
        if array.dtype.kind in "fiub" or all(isinstance(value, Real) for value in array.flat):
            return array.astype(float, copy=False)
    except (OverflowError, TypeError, ValueError) as error:
        raise InputError(f"{name} is no array of numbers: {error}") from None
    raise InputError(f"{name} holds {array.dtype}, where real numbers are needed")


def finite(values, name):
    """``values`` as an array of numbers, none of which is NaN or infinite."""
    array = floats(values, name)
    if not np.isfinite(array).all():
        raise InputError(f"{name} holds NaN or infinity")
    return array


def number(value, name):
    """``value`` as a number."""
    try:
        # Python would read text, and NumPy drop imaginary parts.
        if np.asarray(value).dtype.kind in "fiubO":
            return float(value)
    except (OverflowError, TypeError, ValueError):
        pass
    raise InputError(f"{name} is {_shown(value)}, where a number is needed")


def count(value, name, least=1):
    """``value`` as a whole number of at least ``least``."""
    try:
        whole = operator.index(value)
    except TypeError:
        whole = least - 1
    if whole < least:
        raise InputError(f"{name} is {_shown(value)}, where a whole number of at least {least} is needed")
    return whole


def _shown(value):
    try:
        text = repr(value)
    except ValueError:
        # A whole number of thousands of digits has no repr.
        text = ""
    return text if 0 < len(text) <= 60 else f"a long {type(value).__name__}"
