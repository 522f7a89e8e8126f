"""Arguments that NumPy is to use, refused with a reason where they are none."""

import operator

import numpy as np

from ._errors import InputError


def floats(values, name):
    """``values`` as an array of numbers."""
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} is no array of numbers: {error}") from None


def finite(values, name):
    """``values`` as an array of numbers, none of which is NaN or infinite."""
    array = floats(values, name)
    if not np.isfinite(array).all():
        raise InputError(f"{name} holds NaN or infinity")
    return array


def number(value, name):
    """``value`` as a number."""
    try:
        return float(value)
    except (TypeError, ValueError):
        raise InputError(f"{name} is {_shown(value)}, where a number is needed") from None


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
    text = repr(value)
    return text if len(text) <= 60 else f"a long {type(value).__name__}"
