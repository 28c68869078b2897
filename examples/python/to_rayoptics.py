"""The fitted pair in ray-optics: its surface as a profile, traced and diffracted, its scatter convolved.

ray-optics has lengths in mm, wavelengths in nm, and OPD in waves. It has no profile of Zernikes, but takes
one of ours: a class with the sag, the function f = z - sag and its gradient. The rays travel along +z, so a
concave mirror has a negative radius, and heights towards the light change their sign. The OPD of a grid is
2 h/lambda. The first index of a grid and of its PSF is x. The PSF is turned by 180 degrees, which changes
no energy. ray-optics has no BSDF.
"""

import numpy as np
from rayoptics.elem.profiles import Conic
from rayoptics.optical.opticalmodel import OpticalModel
from rayoptics.raytr.analyses import RayGrid, calc_psf
from rayoptics.raytr.opticalspec import FieldSpec, PupilSpec, WvlSpec

import pair

POINTS = 96  # rays across the mirror; calc_psf needs an even number


class FittedMirror(Conic):
    """A paraboloid with the heights of a Surface [m] on it."""

    def __init__(self, surface, radius):
        super().__init__(r=radius, cc=-1.0)
        self.surface = surface

    def sag(self, x, y):
        return super().sag(x, y) - 1e3 * float(self.surface.heights(1e-3 * x, 1e-3 * y))

    def f(self, p):
        return p[2] - self.sag(p[0], p[1])

    def df(self, p):
        dhdx, dhdy = self.surface.slopes(1e-3 * p[0], 1e-3 * p[1])
        return np.array([float(dhdx) - self.cv * p[0], float(dhdy) - self.cv * p[1], 1.0])

    def intersect(self, p0, d, eps, z_dir):
        return self.intersect_spencer(p0, d, eps, z_dir)  # iterates with f and df


result, halo = pair.fitted_pair()
surface = result.surface
model = OpticalModel()
lenses, spec = model["seq_model"], model["optical_spec"]
spec["pupil"] = PupilSpec(spec, key=["object", "epd"], value=1e3 * pair.DIAMETER)
spec["fov"] = FieldSpec(spec, key=["object", "angle"], value=0.0, flds=[0.0])
spec["wvls"] = WvlSpec([(1e9 * pair.WAVELENGTH, 1.0)], ref_wl=0)
lenses.gaps[0].thi = 1e10
f = 1e3 * pair.FOCAL_LENGTH
lenses.add_surface([-1 / (2 * f), -f, "REFL"], sd=500 * pair.DIAMETER)
lenses.ifcs[lenses.cur_surface].profile = FittedMirror(surface, -2 * f)
lenses.set_stop()
model.update_model()

# One grid of rays for both comparisons, about the focus of the parabola. Its areas are equal. It is wrong by
# 1e-3, and as many random rays would be by 6e-3.
grid = RayGrid(model, num_rays=POINTS, image_pt_2d=np.zeros(2))
rays = [ray for row in grid.grid_pkg[0] for _, _, ray in row if ray is not None]
distance = np.sort([1e-3 * np.hypot(*segments[-1][0][:2]) for segments, _, _ in rays])
theirs = np.searchsorted(distance, pair.RADII) / distance.size
expected = pair.energies_by_rays(surface)
print("rays", distance.size, np.round(expected, 4), np.round(theirs, 4))
if not np.max(np.abs(theirs - expected)) < 5e-3:
    raise SystemExit("ray-optics' rays differ")

# Both rims are points of the grid: its pitch is D/(POINTS - 1), and not the D/POINTS of calc_psf_scaling.
q = round(pair.WAVELENGTH * pair.FOCAL_LENGTH / (pair.DIAMETER * pair.PIXEL))  # pixels per lambda f/D
image = calc_psf(grid.grid[2], POINTS, q * (POINTS - 1))  # an odd number of pixels, the axis in the middle
pair.compare("ray-optics", pair.encircled(pair.scattered(image / image.sum(), halo)), result, 5e-3)
