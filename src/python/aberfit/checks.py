"""Checks of arguments that several functions share."""

from __future__ import annotations

import json
import operator
import os

import numpy as np

from . import _aberfit


def refuse(what, found, allowed):
    """Raises InputError for an argument."""
    error = _aberfit.InputError(f"{what}: found {found}; allowed: {allowed}")
    error.file, error.pointer, error.found, error.allowed = "call", what, str(found), allowed
    raise error


def numbers(what, values):
    """Real numbers as an array, NaN where they are masked."""
    if np.iscomplexobj(values):
        refuse(what, "complex numbers", "real ones")
    try:
        array = np.ma.filled(np.ma.asarray(values).astype(float), np.nan)
    except (TypeError, ValueError):
        refuse(what, repr(values)[:60], "numbers")
    if np.any(np.isinf(array)):
        refuse(what, "infinity", "finite numbers, NaN where unknown")
    return array


def points(what, values, most=np.inf):
    """The shape of values, and the values in a line: numbers from 0 to `most`, NaN where unknown."""
    array = numbers(what, values)
    if np.any(array < 0) or np.any(array > most):
        refuse(
            what,
            "a number outside",
            f"numbers from 0 to {most:g}" if most < np.inf else "numbers from 0 on",
        )
    return array.shape, array.ravel()


def shaped(result, shape, at):
    """The result in the shape of its points, a number for a number; NaN where the point is."""
    result = np.where(np.isnan(at), np.nan, result).reshape(shape)
    return result[()]


def number(what, value):
    """A finite number."""
    array = numbers(what, value)
    if array.ndim != 0 or np.isnan(array):
        refuse(what, repr(value)[:60], "a finite number")
    return float(array)


def positive(what, value, most=np.inf):
    """A finite number above 0, at most `most`."""
    value = number(what, value)
    if not 0 < value <= most:
        refuse(what, value, "a number above 0" if most == np.inf else f"a number above 0, at most {most:g}")
    return value


def whole(what, value, most, least=1):
    """A whole number."""
    try:
        found = operator.index(value)
    except TypeError:
        found = None
    if found is None or isinstance(value, bool) or not least <= found <= most:
        refuse(what, repr(value)[:60], f"a whole number from {least} to {most}")
    return found


def band(f_min, f_max):
    """A band of frequencies [cycles/m]."""
    try:
        f_min, f_max = float(f_min), float(f_max)
    except (TypeError, ValueError):
        refuse("f_min, f_max", f"{f_min!r} and {f_max!r}", "numbers [cycles/m]")
    if not 0 <= f_min < f_max:
        refuse("f_min, f_max", f"{f_min} and {f_max}", "0 <= f_min < f_max")
    return f_min, f_max


def path_text(what, path):
    """The name of a file or folder."""
    if not isinstance(path, (str, os.PathLike)) or "\0" in os.fspath(path):
        refuse(what, repr(path), "the name of a file or folder")
    return os.fspath(path)


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
    except _aberfit.InputError:
        raise
    except ValueError:
        refuse(what, "NaN, infinity or a circle", "finite numbers; a band without end leaves f_max out")
    except (TypeError, RecursionError) as error:
        refuse(what, str(error), "JSON of at most 64 levels, with texts as keys")
