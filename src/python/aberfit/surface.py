"""Surfaces of aberration terms."""

from __future__ import annotations

import operator
import pathlib

import numpy as np

from . import _aberfit
from .checks import number, numbers, path_text, positive, refuse, whole

_MOST_N = 300  # radial order of a Zernike term
_MOST_CYCLES = 1e6  # over the radius; a PSD there is averaged over hundreds of ripples


class Surface:
    """A surface of Zernike terms, plane waves and even powers over a disc. Heights are in m.

    radius: normalisation radius [m].
    zernike: {(n, m): a}, orthonormal on the disc (Noll: RMS of the term is |a|), m > 0 cosine, m < 0 sine.
    noll, osa, fringe: the same by an index, {j: a} or a sequence that starts at 1, 0 and 1. Fringe terms
        are peak-normalised.
    fourier: rows (fx, fy, A, B): A cos + B sin of 2 pi (fx x + fy y), frequencies in cycles/m.
    spherical: {power: height at the rim} for the even powers from 4 to 12.
    """

    def __init__(
        self, *, radius, zernike=None, noll=None, osa=None, fringe=None, fourier=(), spherical=None
    ):
        terms = dict(zernike or {})
        indexed = (
            (noll, 1, _aberfit.from_noll),
            (osa, 0, _aberfit.from_osa),
            (fringe, 1, _aberfit.from_fringe),
        )
        for values, first, mode_of in indexed:
            if values is None:
                continue
            for j, a in values.items() if hasattr(values, "items") else enumerate(values, first):
                mode = mode_of(whole("index", j, (_MOST_N + 1) ** 2, first))
                peak = _aberfit.zernike_norm(*mode) if mode_of is _aberfit.from_fringe else 1.0
                terms[mode] = terms.get(mode, 0.0) + a / peak
        radius = positive("radius", radius)
        modes = []
        for (n, m), a in terms.items():
            n, m = operator.index(n), operator.index(m)
            if not 0 <= n <= _MOST_N or abs(m) > n or (n - m) % 2:
                refuse("zernike", f"({n}, {m})", f"n from 0 to {_MOST_N}, |m| <= n, n - m even")
            modes.append([float(n), float(m), number("zernike", a)])
        waves = numbers("fourier", fourier)
        if waves.size and (waves.ndim != 2 or waves.shape[1] != 4 or np.any(np.isnan(waves))):
            refuse("fourier", f"an array of shape {waves.shape}, or NaN", "rows (fx, fy, A, B)")
        powers = []
        for power, a in sorted((spherical or {}).items()):
            if power not in (4, 6, 8, 10, 12):
                refuse("spherical", power, "powers 4, 6, 8, 10 and 12")
            powers.append([float(power), number("spherical", a)])
        self._terms = _aberfit.TermSurface(radius, modes, waves.reshape(-1, 4).tolist(), powers)

    @classmethod
    def _of(cls, terms):
        made = cls.__new__(cls)
        made._terms = terms
        return made

    def __getstate__(self):
        waves = self.fourier.tolist()
        return {
            "radius": self.radius,
            "zernike": self.zernike,
            "fourier": waves,
            "spherical": self.spherical,
        }

    def __setstate__(self, state):
        self.__init__(**state)

    def __eq__(self, other):
        return isinstance(other, Surface) and self.__getstate__() == other.__getstate__()

    @classmethod
    def read(cls, path, *, radius=None):
        """Reads coefficients.csv, or a Zernike file of CODE V (ZFR or WFR), which needs `radius`."""
        path = path_text("path", path)
        with open(path, encoding="utf-8", errors="replace") as file:
            ours = file.readline().startswith("# aberfit")
        if ours or path.endswith(".csv"):
            return cls._of(_aberfit.read_coefficients_csv(path))
        if radius is None:
            refuse("radius", "none", f"radius=... [m] for {path}, a file of CODE V")
        return cls(fringe=_aberfit.read_codev_zfr(path), radius=radius)

    @property
    def radius(self) -> float:
        """Normalisation radius [m]."""
        return self._terms.radius

    @property
    def zernike(self) -> dict:
        """Zernike coefficients {(n, m): a} [m], orthonormal."""
        return {(int(n), int(m)): a for n, m, a in self._terms.zernike}

    @property
    def fourier(self) -> np.ndarray:
        """Plane waves, rows (fx, fy, A, B) in cycles/m and m."""
        return np.array(self._terms.fourier).reshape(-1, 4)

    @property
    def spherical(self) -> dict:
        """Even powers {power: height at the rim} [m]."""
        return {int(power): a for power, a in self._terms.spherical}

    @property
    def coefficients(self) -> np.ndarray:
        """All coefficients [m]: Zernikes, A and B of each wave, even powers."""
        return np.concatenate(
            [
                np.array([a for _, _, a in self._terms.zernike]),
                self.fourier[:, 2:].ravel(),
                np.array([a for _, a in self._terms.spherical]),
            ]
        )

    def __repr__(self):
        return f"<aberfit.Surface of {self.coefficients.size} terms, radius {self.radius:g} m>"

    # Values.
    def _field(self, x, y):
        x, y = np.broadcast_arrays(numbers("x", x), numbers("y", y))
        field = self._terms.field(x.ravel(), y.ravel())
        return [part.reshape(x.shape)[()] for part in field]

    def heights(self, x, y) -> np.ndarray:
        """Heights [m] at points x, y [m] of any shape. Outside the disc Zernike terms grow quickly."""
        return self._field(x, y)[0]

    def slopes(self, x, y) -> tuple:
        """Slopes (dh/dx, dh/dy) at points x, y [m]."""
        return tuple(self._field(x, y)[1:])

    def grid(self, npix=257, *, width=None) -> tuple:
        """(x, h): heights [m] at npix x npix pixel centres over a square of `width` [m], the diameter if
        absent; row = y, NaN outside the disc."""
        npix = whole("npix", npix, _aberfit.MOST_PIXELS)
        width = 2 * self.radius if width is None else positive("width", width)
        x = (np.arange(npix) - 0.5 * (npix - 1)) * (width / npix)
        inside = x[None, :] ** 2 + x[:, None] ** 2 <= self.radius**2
        h = np.full((npix, npix), np.nan)
        rows, columns = np.nonzero(inside)
        h[rows, columns] = self.heights(x[columns], x[rows])
        return x, h

    def opd(self, npix=257, *, width=None) -> np.ndarray:
        """Optical path difference [m] on such a grid, twice the height, 0 outside the disc. Its sign is that
        of the surface. Programs that count a longer path as positive need -opd, which turns the image by 180
        degrees and leaves its energies as they are. (The grid of the format `fits-opd` ends at the rim: its
        pixels are width/(npix - 1) apart.)"""
        return np.nan_to_num(2 * self.grid(npix, width=width)[1])

    def rms(self, *, inner_radius=0.0) -> float:
        """RMS height about the mean [m] over the disc, or over an annulus; exact."""
        return self._terms.moments(self._inside(inner_radius))[0]

    def rms_slope(self, *, inner_radius=0.0) -> float:
        """RMS slope per axis [rad]; exact."""
        return self._terms.moments(self._inside(inner_radius))[1]

    def psd(self, f=None, *, npix=256) -> tuple:
        """(f, S): two-sided PSD [m^4], averaged over directions.

        Zernike terms alone: the closed form over the whole disc, at the frequencies f [cycles/m]. With other
        terms: the estimate of a measured map on the square inside the disc, at its own frequencies.
        """
        if self.fourier.size or self.spherical:
            if f is not None:
                refuse(
                    "psd", "f with plane waves or even powers", "no f: the estimate has its own frequencies"
                )
            npix = whole("npix", npix, _aberfit.MOST_PIXELS, 16)
            low, high, values = self._terms.estimated(npix)
            return np.sqrt(low * high), values
        if f is None:
            n = max((n for n, _ in self.zernike), default=1)
            f = np.geomspace(0.25 / self.radius, 2 * (n + 1) / (2 * np.pi * self.radius), 100)
        most = _MOST_CYCLES / self.radius
        f = np.atleast_1d(numbers("f", f))
        if f.ndim != 1 or not np.all((f >= 0) & (f <= most)):
            refuse(
                "f", "another shape, NaN or a number outside", f"frequencies from 0 to {most:g} cycles/m"
            )
        return f, self._terms.spectrum(f * (1 - 1e-4), np.maximum(f * (1 + 1e-4), 1e-6 / self.radius))

    def _inside(self, inner_radius):
        inner_radius = number("inner_radius", inner_radius)
        if not 0 <= inner_radius < self.radius:
            refuse("inner_radius", inner_radius, f"from 0 to the radius, {self.radius:g} m")
        return inner_radius

    # Conventions and files.
    def _indexed(self, index, first):
        terms = self.zernike
        places = {index(n, m): a for (n, m), a in terms.items()}
        values = np.zeros(max(places, default=first - 1) - first + 1)
        for j, a in places.items():
            values[j - first] += a
        return values

    def to_noll(self) -> np.ndarray:
        """Zernike coefficients [m] by Noll's index, from 1."""
        return self._indexed(_aberfit.noll_index, 1)

    def to_osa(self) -> np.ndarray:
        """Zernike coefficients [m] by the OSA/ANSI index, from 0."""
        return self._indexed(_aberfit.osa_index, 0)

    def to_fringe(self) -> np.ndarray:
        """Peak-normalised Zernike coefficients [m] by the Fringe index, from 1."""
        values = self._indexed(_aberfit.fringe_index, 1)
        norms = [_aberfit.zernike_norm(*_aberfit.from_fringe(j + 1)) for j in range(values.size)]
        return values * np.array(norms)

    @staticmethod
    def formats() -> list:
        """Names of the formats of `write`."""
        return ["coefficients-csv", *_aberfit.export_names()]

    def write(
        self, path, format, *, wavelength=632.8e-9, npix=257, inner_radius=0.0, title=""
    ) -> pathlib.Path:
        """Writes the surface in a format of `formats()`. path: a file, whose folder is made if need be, or a
        folder for the usual name. wavelength: [m], of formats that need one."""
        if format not in self.formats():
            refuse("format", repr(format), ", ".join(self.formats()))
        if format == "coefficients-csv":
            name, content = "coefficients.csv", self._terms.csv().encode()
        else:
            wavelength = positive("wavelength", wavelength)
            npix = whole("npix", npix, _aberfit.MOST_PIXELS)
            name, content = self._terms.exported(
                format, wavelength, npix, self._inside(inner_radius), title
            )
        path = pathlib.Path(path)
        if path.is_dir():
            path = path / name
        _aberfit.write_file(str(path), content)
        return path
