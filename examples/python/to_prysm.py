"""The fitted pair in prysm: the surface as phase of a pupil, the scatter as a convolution.

prysm counts lengths of the pupil in mm, the phase in nm of optical path, the wavelength in um and the image
in um. A reflected wave has twice the height of the surface.
"""

import numpy as np
from prysm.propagation import Wavefront

import pair

result, halo = pair.fitted_pair()
x, on_mirror = pair.pupil()
h = np.zeros(on_mirror.shape)
rows, columns = np.nonzero(on_mirror)
h[rows, columns] = result.surface.heights(x[columns], x[rows])

wave = Wavefront.from_amp_and_phase(
    on_mirror.astype(float), 2e9 * h, pair.WAVELENGTH * 1e6, 1e3 * (x[1] - x[0])
)
q = round(pair.WAVELENGTH * pair.FOCAL_LENGTH / (pair.DIAMETER * pair.PIXEL))  # pixels per lambda f/D
focus = wave.focus(1e3 * pair.FOCAL_LENGTH, Q=q).intensity.data
psf = focus / focus.sum()  # fractions of the energy: the transform keeps all of it
middle, half = psf.shape[0] // 2, pair.FRAME // 2  # the axis is at this pixel
psf = psf[middle - half : middle + half + 1, middle - half : middle + half + 1]
pair.compare("prysm", pair.encircled(pair.scattered(psf, halo)), result, 5e-3)
