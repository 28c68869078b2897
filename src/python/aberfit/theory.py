"""Theory without a fit: power spectral densities, and the mean focus of a rough mirror."""

from __future__ import annotations

import json

import numpy as np

from . import _aberfit
from .checks import band, number, numbers, points, positive, refuse, shaped, whole
from .data import study_text

_SCENE = {
    "aberfit": 1,
    "mirror": {"focal_length": 1.0},
    "aperture": {"shape": "circle", "diameter": 0.1},
    "light": {"wavelength": 1e-6},
}


def psd_models() -> dict:
    """The models of a PSD and their keys, {model: [key, ...]}."""
    schema = json.loads(_aberfit.study_schema())
    blocks = [block["properties"] for block in schema["$defs"]["psd"]["oneOf"]]
    return {block["model"]["const"]: [key for key in block if key != "model"] for block in blocks}


class Psd:
    """An isotropic two-dimensional, two-sided PSD of surface heights, S(f) [m^4] over f [cycles/m].

    Arguments are those of a block `roughness.psd`, e.g. Psd(model="k-correlation", rms="20 nm",
    correlation_length="0.2 m", exponent=2.5, f_max="1 /mm"); `psd_models()` lists them.
    """

    def __init__(self, **block):
        self.block = block
        self._psd = _aberfit.RadialPsd(study_text({**_SCENE, "roughness": {"psd": block}}))

    def __getstate__(self):
        return self.block

    def __setstate__(self, block):
        self.__init__(**block)

    def __repr__(self):
        return f"Psd({', '.join(f'{key}={value!r}' for key, value in self.block.items())})"

    def __call__(self, f):
        """S(f) [m^4], 0 outside the band."""
        shape, at = points("f", f)
        return shaped(self._psd(at), shape, at)

    @property
    def band(self) -> tuple:
        """(f_min, f_max) [cycles/m]."""
        return self._psd.f_min, self._psd.f_max

    def rms(self, f_min=0.0, f_max=np.inf) -> float:
        """RMS height in a band [m]."""
        return self._psd.rms(*band(f_min, f_max))[0]

    def rms_slope(self, f_min=0.0, f_max=np.inf) -> float:
        """RMS slope per axis in a band [rad]."""
        return self._psd.rms(*band(f_min, f_max))[1]

    def autocorrelation(self, r):
        """C(r) [m^2] at distances r [m]."""
        shape, at = points("r", r)
        return shaped(self._psd.autocorrelation(at), shape, at)

    def structure_function(self, r):
        """2 (C(0) - C(r)) [m^2] at distances r [m]."""
        shape, at = points("r", r)
        return shaped(2 * self._psd.structure_function(at), shape, at)


class Halo:
    """Scatter as an image, for programs that convolve: PSF = core PSF + (PSF convolved with `kernel`).

    kernel: fraction of the energy per pixel (y x x), the axis in the middle. core: fraction that is not
    scattered. halo: sum of the kernel. beyond: fraction scattered beyond the frame. core + halo + beyond = 1.
    pixel: its side [m]. One kernel serves all of a mirror, so it leaves out that light at an angle to the
    surface scatters less: 1.4 % of the scatter at f/2, 6 % at f/1.
    """

    def __init__(self, kernel, core, halo, beyond, pixel):
        self.kernel, self.core, self.halo, self.beyond, self.pixel = kernel, core, halo, beyond, pixel

    def __repr__(self):
        return (
            f"<aberfit.Halo: core {self.core:.6g}, halo {self.halo:.6g}, beyond {self.beyond:.6g}, "
            f"{self.kernel.shape[0]} pixels of {self.pixel:g} m>"
        )

    @property
    def whole(self) -> np.ndarray:
        """The kernel with the core in the middle: one convolution gives the PSF with its scatter. Needs an
        odd number of pixels."""
        if self.kernel.shape[0] % 2 == 0:
            refuse("halo.whole", "an even number of pixels", "an odd one")
        with_core = self.kernel.copy()
        middle = self.kernel.shape[0] // 2
        with_core[middle, middle] += self.core
        return with_core


class MeanLight:
    """The mean focus of mirrors with one roughness, by generalised Harvey-Shack theory; see `ghs`."""

    def __init__(self, study, profile=None, map=None, mask=None):
        self.study, self._data = study, (profile, map, mask)
        self._light = _aberfit.MeanLight(study_text(study, None, *self._data))

    def __getstate__(self):
        return self.study, *self._data

    def __setstate__(self, given):
        self.__init__(*given)

    def __repr__(self):
        return f"<aberfit.MeanLight: g {self.g:.4g}, TIS {100 * self.tis:.4g} %>"

    @property
    def g(self) -> float:
        """4 pi sigma/lambda."""
        return self._light.g

    @property
    def tis(self) -> float:
        """Fraction of the energy that is scattered: 1 - exp(-g^2), and less for fast mirrors, on which light
        arrives at an angle."""
        return self._light.tis

    def _at(self, what, function, values, *more, most=np.inf):
        shape, at = points(what, values, most)
        return shaped(function(at, *more), shape, at)

    def encircled_energy(self, radius, dz=0.0):
        """Fraction of the energy within radii [m] in the plane dz [m] behind the focus."""
        return self._at("radius", self._light.encircled_energy, radius, number("dz", dz))

    def encircled_energy_radius(self, fraction, dz=0.0):
        """Radii [m] that hold fractions of the energy; NaN where none does."""
        return self._at(
            "fraction", self._light.encircled_energy_radius, fraction, number("dz", dz), most=1.0
        )

    def irradiance(self, radius, dz=0.0):
        """Mean irradiance at radii [m], for a total energy of 1 [1/m^2]."""
        return self._at("radius", self._light.irradiance, radius, number("dz", dz))

    def psf(self, pixel, npix, dz=0.0):
        """Fraction of the energy per pixel of an image of npix x npix pixels of `pixel` [m] (y x x), right to
        1e-6 for pixels of any size. The light of an aperture that is not round is averaged over
        directions."""
        npix = whole("npix", npix, _aberfit.MOST_PIXELS)
        pixel = positive("pixel", pixel, self._light.focal_length)
        return self._light.image(number("dz", dz), 0.5 * pixel * npix, npix)

    def otf(self, frequency):
        """Transfer function in the focus at frequencies [cycles/m] of the image: its real part, averaged over
        directions."""
        return self._at("frequency", self._light.transfer, np.abs(numbers("frequency", frequency)))

    def bsdf(self, theta, *, f_min=0.0, f_max=np.inf):
        """BSDF [1/sr] of the roughness in a band at angles [rad] from the specular direction."""
        return self._at("theta", self._light.bsdf, theta, *band(f_min, f_max), most=0.5 * np.pi)

    def scattered_within(self, theta, *, f_min=0.0, f_max=np.inf):
        """Fraction of the energy scattered to within angles [rad] of the specular direction."""
        return self._at("theta", self._light.scattered_within, theta, *band(f_min, f_max), most=0.5 * np.pi)

    def halo(self, pixel, npix, *, f_min=0.0, f_max=np.inf) -> Halo:
        """The scatter of the roughness in a band as a kernel of npix x npix pixels of `pixel` [m] in the
        focus. With f_min the cut of a fit, it is the scatter that the terms leave."""
        npix = whole("npix", npix, _aberfit.MOST_PIXELS)
        pixel = positive("pixel", pixel, self._light.focal_length)
        found = self._light.halo_kernel(pixel, npix, *band(f_min, f_max))
        return Halo(found.fraction, found.core, found.halo, found.beyond, pixel)


def ghs(
    study=None,
    *,
    focal_length=None,
    diameter=None,
    obscuration=None,
    wavelength=None,
    psd=None,
    profile=None,
    map=None,
    mask=None,
) -> MeanLight:
    """The mean focus of a rough mirror. Either a study (a dict or a path), or

    focal_length, diameter, wavelength: numbers [m] or texts with a unit. obscuration: diameter of a central
    hole. psd: a Psd, or a block `roughness.psd`.

    profile, map, mask: in place of the files of a measured PSD, as for `fit`.
    """
    parts = [focal_length, diameter, obscuration, wavelength, psd]
    if study is not None and any(part is not None for part in parts):
        refuse("ghs", "a study and parts of one", "one of the two")
    if study is None:
        aperture = {"shape": "circle", "diameter": diameter}
        if obscuration is not None:
            aperture = {"shape": "annulus", "diameter": diameter, "inner_diameter": obscuration}
        study = {
            "aberfit": 1,
            "mirror": {"focal_length": focal_length},
            "aperture": aperture,
            "light": {"wavelength": wavelength},
            "roughness": {"psd": psd.block if isinstance(psd, Psd) else psd},
        }
    return MeanLight(study, profile, map, mask)
