"""Arguments that NumPy is to use, refused with a reason where they are none."""

import operator
from numbers import Real

import numpy as np

from ._errors import InputError

# As many numbers fit in no memory.
MANY = 2**40


def floats(values, name):
    """``values`` as an array of real numbers, none of which is masked."""
    refuse_masked(values, name)
    try:
        array = np.asarray(values)
        # Python's own numbers, such as fractions, are objects.
        if array.dtype.kind in "fiub" or all(isinstance(value, Real) for value in array.flat):
            return array.astype(float, copy=False)
    except (OverflowError, TypeError, ValueError) as error:
        raise InputError(f"{name} is no array of numbers: {error}") from None
    raise InputError(f"{name} holds {array.dtype}, where real numbers are needed")


def refuse_masked(values, name):
    """Refuses ``values`` some of which are masked: those beneath the mask are not meant."""
    if np.ma.is_masked(values):
        raise InputError(f"{name} has masked values")


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
    """``value`` as a whole number of at least ``least`` and less than fills any memory."""
    try:
        whole = operator.index(value)
    except TypeError:
        whole = least - 1
    if not least <= whole < MANY:
        bound = " and below 2**40" if whole >= MANY else ""
        wanted = f"a whole number of at least {least}{bound}"
        raise InputError(f"{name} is {_shown(value)}, where {wanted} is needed")
    return whole


def flag(value, name):
    """``value`` as True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise InputError(f"{name} is {_shown(value)}, where True or False is needed")
    return bool(value)


def _shown(value):
    try:
        text = repr(value)
    except ValueError:
        # A whole number of thousands of digits has no repr.
        text = ""
    return text if 0 < len(text) <= 60 else f"a long {type(value).__name__}"
