"""The fitted pair in HCIPy: the surface as phase, a Fraunhofer propagator to the focus.

HCIPy has metres everywhere and fields as flat lists of points; a SurfaceApodizer would double heights by its
refractive index of -1.
"""

import hcipy
import numpy as np

import pair

result, halo = pair.fitted_pair()
grid = hcipy.make_pupil_grid(pair.PUPIL, pair.DIAMETER)
aperture = hcipy.make_circular_aperture(pair.DIAMETER)(grid)
inside = aperture > 0
h = np.zeros(grid.size)
h[inside] = result.surface.heights(grid.x[inside], grid.y[inside])
wave = hcipy.Wavefront(
    hcipy.Field(aperture * np.exp(4j * np.pi * h / pair.WAVELENGTH), grid), pair.WAVELENGTH
)
wave.total_power = 1
image = hcipy.CartesianGrid(
    hcipy.RegularCoords(
        pair.PIXEL, [pair.FRAME, pair.FRAME], -0.5 * pair.PIXEL * (pair.FRAME - 1) * np.ones(2)
    )
)
focus = hcipy.FraunhoferPropagator(grid, image, focal_length=pair.FOCAL_LENGTH)(wave)
psf = focus.power.shaped
pair.compare("HCIPy", pair.encircled(pair.scattered(psf, halo)), result, 5e-3)
