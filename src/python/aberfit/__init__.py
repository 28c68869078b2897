"""aberfit: equivalent aberration terms of rough mirrors.

A *study* is a dict, or the path of a study file: a mirror, its aperture, the light and the roughness. The
program's commands are functions of a study that return a `Result`:

    import aberfit
    study = {
        "aberfit": 1,
        "mirror": {"focal_length": "2.8 m"},
        "aperture": {"shape": "circle", "diameter": "0.4 m"},
        "light": {"wavelength": "632.8 nm"},
        "roughness": {"psd": {"model": "uniform", "rms": "100 nm", "f_min": "2.5 /m", "f_max": "19.96 /m"}},
    }
    result = aberfit.fit(study)
    print(result)                       # the table of the program
    result.surface.heights(0.0, 0.1)    # the fitted terms, as a Surface

Quantities of a study are texts with a unit or plain numbers in SI units; all other numbers and arrays are in
SI units and radians. Heights are those of the surface, not of the wavefront, positive towards the incoming
light.
"""

import atexit as _atexit
import os as _os

from . import _aberfit
from ._aberfit import ComputationError, InputError, __version__
from .commands import chart, check, fit, psd, schema, solve, sweep, trace, verify
from .data import Map, Profile
from .result import Result
from .surface import Surface
from .theory import Halo, MeanLight, Psd, ghs, psd_models

__all__ = [
    "ComputationError",
    "Halo",
    "InputError",
    "Map",
    "MeanLight",
    "Profile",
    "Psd",
    "Result",
    "Surface",
    "__version__",
    "chart",
    "check",
    "fit",
    "ghs",
    "psd",
    "psd_models",
    "schema",
    "solve",
    "sweep",
    "trace",
    "verify",
]

_atexit.register(_aberfit.end_all)  # work on other threads ends before the interpreter does
_os.register_at_fork(after_in_child=_aberfit.forget_all)
