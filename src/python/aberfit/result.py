"""Results of the commands."""

from __future__ import annotations

import collections.abc
import functools
import json
import types

import numpy as np

from . import _aberfit
from .checks import number, path_text, positive, refuse, whole
from .surface import Surface
from .theory import Halo


class _Kept:
    """What remains of an answer in another process."""

    def __init__(self, answer):
        self.json, self.code, self.headline = answer.json, answer.code, answer.headline
        self._shown = answer.text(), answer.first_screen(), answer.html()
        try:
            self._focus = answer.focus()
        except _aberfit.ComputationError:  # nothing to show
            self._focus = None

    def text(self):
        return self._shown[0]

    def first_screen(self):
        return self._shown[1]

    def html(self):
        return self._shown[2]

    def focus(self):
        return self._focus

    def image(self, *frame):
        refuse("image", "a pickled or copied result", "the result of the command itself")

    def save(self, settings):
        refuse(
            "save", "a pickled or copied result", "the result of the command itself; `report` writes a page"
        )


class Result(collections.abc.Mapping):
    """The result of a command: a mapping with the names of result.json (`aberfit.schema("results")` explains
    them), numbers in SI units. `print(result)` shows the table of the program, a notebook its report."""

    def __init__(self, answer, threads=0, surface=None):
        self._answer = answer
        self._threads = threads
        self._traced = surface

    def __getstate__(self):
        """A pickled result has its numbers, page and arrays, which are computed for it, but cannot `save`."""
        return {"_answer": _Kept(self._answer), "_threads": self._threads, "_traced": self._traced}

    # The mapping.
    @functools.cached_property
    def document(self) -> dict:
        """The content of result.json."""
        return json.loads(self._answer.json)

    def __getitem__(self, key):
        return self.document[key]

    def __iter__(self):
        return iter(self.document)

    def __len__(self):
        return len(self.document)

    def __repr__(self):
        return f"<aberfit {self['kind']}{': ' if self.headline else ''}{self.headline}>"

    def __str__(self):
        return self._answer.text()

    def _repr_html_(self):
        return self._answer.first_screen()

    # The answer.
    @property
    def json(self) -> str:
        """The text of result.json, as the program writes it."""
        return self._answer.json

    @property
    def headline(self) -> str:
        """The answer in a sentence; empty for commands that judge nothing."""
        return self._answer.headline

    @property
    def exit_code(self) -> int:
        """What the program would return: 0 done, and equivalent where judged; 1 not met; 4 interrupted."""
        return self._answer.code

    @property
    def verdict(self) -> str | None:
        """ "equivalent", "different" or "undecided"; None for commands that judge nothing."""
        return self.document.get("equivalence", self.document).get("verdict")

    @property
    def interrupted(self) -> bool:
        """Ctrl-C ended the run; this is the best so far."""
        return self._answer.code == 4

    @property
    def warnings(self) -> list:
        """Warnings of the result, {"code": ..., "message": ...} each."""
        return self.document.get("warnings", [])

    # Arrays.
    @functools.cached_property
    def surface(self) -> Surface | None:
        """The fitted terms, or the Surface that `trace` or `verify` was given; otherwise None."""
        found = self.document.get("coefficients")
        if not found:
            return self._traced
        return Surface(
            zernike={(t["n"], t["m"]): t["value_m"] for t in found["zernike"]},
            fourier=[(t["fx_per_m"], t["fy_per_m"], t["cos_m"], t["sin_m"]) for t in found["fourier"]],
            spherical={int(power[1:].rstrip("_m")): value for power, value in found["spherical"].items()},
            radius=found["radius_m"],
        )

    @property
    def coefficients(self) -> np.ndarray | None:
        """Values of the terms [m], in the order of coefficients.csv; None without a surface."""
        return self.surface.coefficients if self.surface else None

    @functools.cached_property
    def _focus(self):
        return self._answer.focus()

    def _need_focus(self):
        if self._focus is None:
            raise _aberfit.ComputationError(f"aberfit {self['kind']} has no focus to show")
        return self._focus

    @property
    def theory(self) -> types.SimpleNamespace | None:
        """The mean focus of theory as arrays, see `focus`; None without roughness. `psd`, `verify`, `solve`
        and `chart` have no focus and raise ComputationError."""
        found = self._need_focus().get("theory")
        return types.SimpleNamespace(**found) if found else None

    @property
    def focus(self) -> types.SimpleNamespace | None:
        """The focus of the surface as arrays, without copies; computed when first asked for.

        encircled_energy: fraction of the energy (planes x radii), at `plane` and `radius`.
        ring_profile: mean irradiance between neighbouring radii [1/m^2] (planes x rings).
        psf: mean irradiance of a pixel at best focus [1/m^2] (y x x), at `pixel`; its sum times the area of a
            pixel is the fraction of the energy inside the frame.
        otf (by wave optics): complex, `otf_step` apart [cycles/m]; mtf (of theory): at `frequency`.
        """
        found = self._need_focus().get("surface")
        return types.SimpleNamespace(**found) if found else None

    @property
    def plane(self) -> np.ndarray:
        """Defocus of the planes of `focus` [m]."""
        return self._need_focus()["plane"]

    @property
    def radius(self) -> np.ndarray:
        """Radii of the encircled energies of `focus` [m]."""
        return self._need_focus()["radius"]

    @property
    def pixel(self) -> np.ndarray:
        """Centres of the pixels of `focus.psf` [m], the same along x and y."""
        return self._need_focus()["pixel"]

    @property
    def frequency(self) -> np.ndarray:
        """Frequencies of `theory.mtf` [cycles/m]."""
        return self._need_focus()["frequency"]

    @property
    def halo(self) -> Halo | None:
        """The scatter of the roughness that is no term, on the pixels of `focus.psf`, which has it already.
        None where the terms have all of it."""
        found = self._need_focus().get("halo")
        return Halo(*found, float(self.pixel[1] - self.pixel[0])) if found else None

    @property
    def scatter(self) -> types.SimpleNamespace | None:
        """The same scatter over the angle `theta` from the specular direction [rad]: `bsdf` [1/sr], and
        `tis_within`, the fraction of the energy scattered to within theta."""
        found = self._need_focus().get("scatter")
        return types.SimpleNamespace(**found) if found else None

    @property
    def psf(self) -> np.ndarray:
        """`focus.psf`: irradiance of the surface's spot [1/m^2]; of theory for commands without a surface."""
        return (self.focus or self.theory).psf

    def image(self, pixel, npix, dz=0.0) -> np.ndarray:
        """Fraction of the energy per pixel (y x x) of the surface's spot with its scatter, on npix x npix
        pixels of `pixel` [m] in the plane dz [m] behind the focus: what a detector sees. Of theory, averaged
        over directions, for commands without a surface."""
        pixel, npix = positive("pixel", pixel), whole("npix", npix, _aberfit.MOST_PIXELS)
        image = self._answer.image(pixel, npix, number("dz", dz))
        if image is None:
            self._need_focus()
        return image

    # Files.
    def save(self, folder, *, pictures=None, arrays=None, force=False):
        """Writes the files that the program writes: result.json, report.html, tables and pictures."""
        if not folder:
            refuse("folder", repr(folder), "the name of a folder")
        from .commands import _settings

        call = f"aberfit.{self['kind']} of Python"
        self._answer.save(_settings(folder, pictures, arrays, force, self._threads or None, call))

    def report(self, path):
        """Writes report.html without pictures, one file, to `path`."""
        _aberfit.write_file(path_text("path", path), self._answer.html().encode())

    def to_frame(self):
        """The main table as a pandas DataFrame: the statistics (of `verify` those that decide), the budgets
        of `solve`, the octaves of `psd`, the methods of `chart`."""
        import pandas

        found = self.document
        if self["kind"] == "fit":
            found = found.get("equivalence", found)
        if found.get("decided_by") == "light":
            found = found["light"]
        keys = {"fit": "metrics", "check": "target", "solve": "budgets", "psd": "octaves", "chart": "rows"}
        rows = found.get(keys.get(self["kind"], "statistics"), [])
        if isinstance(rows, dict):
            values = [v if isinstance(v, dict) else {"value": v} for v in rows.values()]
            rows = [{"name": name, **value} for name, value in zip(rows, values)]
        frame = pandas.json_normalize(rows)
        return frame.set_index("name") if "name" in frame else frame
