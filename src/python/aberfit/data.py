"""Measurements in memory, in place of the files that a study names."""

from __future__ import annotations

import dataclasses

import numpy as np

from . import _aberfit
from .checks import refuse


@dataclasses.dataclass
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


@dataclasses.dataclass
class Profile:
    """One scan line over a surface.

    x: positions [m], ascending. value: heights [m], or slopes [rad] if `quantity` is "slope"; NaN where
    nothing was measured.
    """

    x: np.ndarray
    value: np.ndarray
    quantity: str = "height"


def _matrix(values, what):
    matrix = np.asarray(values)
    if np.iscomplexobj(matrix):
        refuse(what, "complex numbers", "real ones")
    matrix = matrix.astype(float)
    if matrix.ndim != 2 or matrix.size == 0:
        refuse(what, f"an array of shape {matrix.shape}", "rows and columns")
    return matrix


def study_data(profile=None, map=None, mask=None):
    """The arrays in the form of the compiled part."""
    data = _aberfit.StudyData()
    if map is not None:
        if not isinstance(map, Map):
            raise TypeError("map is an aberfit.Map(height, pitch)")
        height = _matrix(map.height, "map.height")
        pitch = np.broadcast_to(np.asarray(map.pitch, dtype=float), 2)
        origin = map.origin
        if origin is None:
            origin = -0.5 * pitch[0] * (height.shape[1] - 1), -0.5 * pitch[1] * (height.shape[0] - 1)
        data.put_map(height, pitch[0], pitch[1], origin[0], origin[1])
    if profile is not None:
        if not isinstance(profile, Profile):
            raise TypeError("profile is an aberfit.Profile(x, value)")
        x, value = (np.asarray(a, dtype=float).ravel() for a in (profile.x, profile.value))
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
        data.put_mask(_matrix(mask, "mask"))
    return data
