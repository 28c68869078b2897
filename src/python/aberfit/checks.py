"""Checks of arguments that several functions share."""

from __future__ import annotations

import json
import math
import os

import numpy as np

from . import _aberfit


def refuse(what, found, allowed):
    """Raises InputError for an argument."""
    error = _aberfit.InputError(f"{what}: found {found}; allowed: {allowed}")
    error.file, error.pointer, error.found, error.allowed = "call", what, str(found), allowed
    raise error


def points(what, values):
    """The shape of values, and the values in a line: finite numbers from 0 on, NaN where unknown."""
    array = np.asarray(values, dtype=float)
    if np.any(array < 0) or np.any(np.isinf(array)):
        refuse(what, "a negative or infinite number", "numbers from 0 on")
    return array.shape, np.ascontiguousarray(array).ravel()


def shaped(result, shape, at):
    """The result in the shape of its points, a number for a number; NaN where the point is."""
    result = np.where(np.isnan(at), np.nan, result).reshape(shape)
    return result[()]


def positive(what, value, least=0.0):
    """A finite number above `least`."""
    if not (isinstance(value, (int, float, np.number)) and math.isfinite(value) and value > least):
        refuse(what, value, f"a finite number above {least:g}")
    return float(value)


def pixels(what, count, most):
    """A number of pixels a side."""
    if not isinstance(count, (int, np.integer)) or not 1 <= count <= most:
        refuse(what, count, f"a whole number from 1 to {most}")
    return int(count)


def band(f_min, f_max):
    """A band of frequencies [cycles/m]."""
    if not 0 <= f_min < f_max:
        refuse("f_min, f_max", f"{f_min} and {f_max}", "0 <= f_min < f_max")
    return float(f_min), float(f_max)


def json_text(value, what):
    """JSON of dicts, lists, texts and numbers, NumPy's among them."""

    def plain(other):
        if isinstance(other, np.generic):
            return other.item()
        if isinstance(other, np.ndarray):
            return other.tolist()
        if isinstance(other, os.PathLike):
            return os.fspath(other)
        refuse(what, f"a {type(other).__name__}", "dicts, lists, texts, numbers, true, false and None")

    try:
        return json.dumps(value, default=plain, allow_nan=False)
    except ValueError:
        refuse(what, "NaN or infinity", "finite numbers; a band without end leaves f_max out")
