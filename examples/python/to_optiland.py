"""The fitted pair in optiland: its Zernike surface, traced and diffracted, and a BSDF of the scatter.

optiland has lengths in mm and wavelengths in um. The rays travel along +z, so a concave mirror has a
negative radius, and heights towards the light change their sign. Its types "fringe" (peak 1), "noll" and
"standard" (OSA; both orthonormal) are our conventions, and x and y are ours. Fringe is used here: up to
version 0.6.0 the normals of the other two lack the normalisation (issue 662), so only their sag is right.
The surface ends at `norm_radius`.

optiland has a Lambertian and a Gaussian BSDF, and roughness scatters like neither. A class of our own draws
the angles from our table; `bsdf=` of the mirror takes it, for the rays of `trace`. A PSF needs a mirror
without it, since it takes the phase from those rays: there the scatter is a convolution.
"""

import numpy as np
from numba import njit
from optiland.optic import Optic
from optiland.psf import MMDFTPSF
from optiland.rays import RealRays
from optiland.scatter import BaseBSDF

import aberfit
import pair

POINTS = 97  # rays across the mirror
SCATTERED = 20000  # rays about a normal


class TabulatedBSDF(BaseBSDF):
    """Scatters to within sin(angle) with the probability `within`, which starts with the specular part."""

    def __init__(self, sine, within):
        @njit
        def offset():
            radius = np.interp(np.random.rand(), within, sine)
            direction = 2 * np.pi * np.random.rand()
            return radius * np.cos(direction), radius * np.sin(direction)

        self.scattering_function = offset


@njit
def seed(number):
    """Numba has random numbers of its own, which only compiled code can seed."""
    np.random.seed(number)


result, halo = pair.fitted_pair()
surface = result.surface
f, wavelength = 1e3 * pair.FOCAL_LENGTH, 1e6 * pair.WAVELENGTH
optic = Optic()
optic.surfaces.add(index=0, thickness=np.inf)
optic.surfaces.add(
    index=1,
    surface_type="zernike",
    radius=-2 * f,
    conic=-1,
    coefficients=-1e3 * surface.to_fringe(),
    zernike_type="fringe",
    norm_radius=1e3 * surface.radius,
    thickness=-f,
    material="mirror",
    is_stop=True,
)
optic.surfaces.add(index=2)
optic.set_aperture("EPD", 1e3 * pair.DIAMETER)
optic.fields.set_type("angle")
optic.fields.add(y=0)
optic.wavelengths.add(wavelength, is_primary=True)

# Rays on a square grid of equal areas. The grid is wrong by 2e-3, as many random rays would be by 6e-3.
rays = optic.trace(0, 0, wavelength, POINTS, "uniform")
distance = np.sort(1e-3 * np.hypot(rays.x, rays.y))
theirs = np.searchsorted(distance, pair.RADII) / distance.size
expected = pair.energies_by_rays(surface)
print("rays", np.round(expected, 4), np.round(theirs, 4))
if not np.max(np.abs(theirs - expected)) < 5e-3:
    raise SystemExit("optiland's rays differ")

# Diffraction, over the whole period of the transform but one pixel: the sum is all of the energy.
# The reference sphere is about the axis: at its very centre optiland's mirror has no slope of the terms.
q = round(pair.WAVELENGTH * pair.FOCAL_LENGTH / (pair.DIAMETER * pair.PIXEL))  # pixels per lambda f/D
image = MMDFTPSF(
    optic,
    (0, 0),
    wavelength,
    num_rays=POINTS,
    image_size=q * (POINTS - 1) - 1,
    pixel_pitch=1e6 * pair.PIXEL,
).psf
pair.compare("optiland", pair.encircled(pair.scattered(image / image.sum(), halo)), result, 5e-3)

# Scatter of the roughness above the cut, about the normal.
theory = aberfit.ghs(pair.STUDY)
angle = np.concatenate([[0.0], np.geomspace(1e-5, 1e-2, 400)])  # [rad]
scattered = theory.scattered_within(angle, f_min=20.0)
bsdf = TabulatedBSDF(np.sin(angle), 1 - scattered[-1] + scattered)
zero, one = np.zeros(SCATTERED), np.ones(SCATTERED)
seed(1)
rays = bsdf.scatter(RealRays(zero, zero, zero, zero, zero, one, one, wavelength * one), 0.0, 0.0, 1.0)
for theta in (0.0, 5e-5, 1e-4, 2e-4):
    outside = scattered[-1] - theory.scattered_within(theta, f_min=20.0)
    theirs = np.mean(np.hypot(rays.L, rays.M) > np.sin(theta))
    print(f"scattered beyond {theta:.0e} rad {outside:.4f} {theirs:.4f}")
    if not abs(theirs - outside) < 4 * np.sqrt(outside / SCATTERED):  # standard errors
        raise SystemExit("optiland's scatter differs")
