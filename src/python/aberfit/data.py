"""Measurements in memory, in place of the files that a study names."""

from __future__ import annotations

import dataclasses
import os

import numpy as np

from . import _aberfit
from .checks import json_text, numbers, path_text, positive, refuse


@dataclasses.dataclass(eq=False)
class Map:
    """Heights on a regular grid.

    height: (rows, columns) [m], of the surface; row 0 at the lowest y; NaN where nothing was measured.
    pitch: distance of neighbours [m], one number or (pitch_x, pitch_y).
    origin: position (x, y) of row 0, column 0 [m]; absent: the axis is in the middle of the grid. A study
        uses it with `"origin": "file"` in `target.map`; by default the axis is at the centre of the valid
        points.

    `of`, `value_unit`, `pitch`, `scale` and `invalid` of the study apply to it, as to a file without units.
    """

    height: np.ndarray
    pitch: float | tuple[float, float]
    origin: tuple[float, float] | None = None


@dataclasses.dataclass(eq=False)
class Profile:
    """One scan line over a surface.

    x: positions [m], ascending. value: heights [m], or slopes [rad] if `quantity` is "slope"; NaN where
    nothing was measured.
    """

    x: np.ndarray
    value: np.ndarray
    quantity: str = "height"


def _matrix(what, values):
    matrix = numbers(what, values)
    if matrix.ndim != 2 or matrix.size == 0:
        refuse(what, f"an array of shape {matrix.shape}", "rows and columns")
    return matrix


def _study_data(profile, map, mask):
    """The arrays in the form of the compiled part."""
    data = _aberfit.StudyData()
    if map is not None:
        if not isinstance(map, Map):
            refuse("map", f"a {type(map).__name__}", "an aberfit.Map(height, pitch)")
        height = _matrix("map.height", map.height)
        pitch = numbers("map.pitch", map.pitch)
        if pitch.shape not in ((), (2,)):
            refuse("map.pitch", repr(map.pitch), "a number [m], or two")
        pitch = [positive("map.pitch", step) for step in np.broadcast_to(pitch, 2)]
        origin = map.origin
        if origin is None:
            origin = -0.5 * pitch[0] * (height.shape[1] - 1), -0.5 * pitch[1] * (height.shape[0] - 1)
        origin = numbers("map.origin", origin)
        if origin.shape != (2,) or np.any(np.isnan(origin)):
            refuse("map.origin", repr(map.origin), "two numbers [m]")
        data.put_map(height, pitch[0], pitch[1], origin[0], origin[1])
    if profile is not None:
        if not isinstance(profile, Profile):
            refuse("profile", f"a {type(profile).__name__}", "an aberfit.Profile(x, value)")
        x, value = numbers("profile.x", profile.x).ravel(), numbers("profile.value", profile.value).ravel()
        if x.size != value.size or x.size < 2 or not np.all(np.diff(x) > 0):
            refuse(
                "profile",
                "other positions or another number of values",
                "ascending positions, one value each",
            )
        if profile.quantity not in ("height", "slope"):
            refuse("profile.quantity", repr(profile.quantity), '"height" or "slope"')
        data.put_profile(x, value, profile.quantity == "slope")
    if mask is not None:
        data.put_mask(_matrix("mask", mask))
    return data


def study_text(study, changes=None, profile=None, map=None, mask=None):
    """A dict or a path, with data in place of its files, as the compiled part takes it."""
    if changes is not None and not hasattr(changes, "items"):
        refuse("changes", repr(changes), '{"/json/pointer": value}')
    changes = [f"{pointer}={json_text(value, pointer)}" for pointer, value in (changes or {}).items()]
    data = _study_data(profile, map, mask)
    if isinstance(study, (str, os.PathLike)):
        return _aberfit.StudyText("", path_text("study", study), changes, data)
    return _aberfit.StudyText(json_text(study, "study"), "study", changes, data)
