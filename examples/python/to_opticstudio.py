"""The fitted pair as files for OpticStudio: the surface as a Grid Sag, its scatter as a table.

No program is needed: the grid is read back with a reader of its own, and diffracted. OpticStudio has lens
units (mm), the first row of a grid at the top, and bicubic interpolation with the derivatives that the file
holds.
`scatter.csv` of a fit becomes a BSDF of a Scatter Function, or its ABg parameters where they suit.
"""

import tempfile

import numpy as np

import pair


def read_grid_sag(path):
    """Heights [m] of a .DAT of OpticStudio, row 0 at the lowest y, and the pitch [m]."""
    with open(path, encoding="utf-8") as file:
        lines = [line.split() for line in file if line.strip() and not line.startswith("!")]
    columns, rows, pitch = int(lines[0][0]), int(lines[0][1]), float(lines[0][2]) * 1e-3
    values = np.array([[float(v) for v in line[:5]] for line in lines[1:]])
    height = np.where(values[:, 4] != 0, 0.0, values[:, 0]) * 1e-3
    return height.reshape(rows, columns)[::-1], pitch


result, halo = pair.fitted_pair()
with tempfile.TemporaryDirectory() as folder:
    path = result.surface.write(folder, "zemax-grid-sag", wavelength=pair.WAVELENGTH, npix=pair.PUPIL + 1)
    height, pitch = read_grid_sag(path)
n = height.shape[0]
x = (np.arange(n) - 0.5 * (n - 1)) * pitch
on_mirror = x[None, :] ** 2 + x[:, None] ** 2 <= (0.5 * pair.DIAMETER) ** 2
field = on_mirror * np.exp(4j * np.pi * height / pair.WAVELENGTH)

# The image at our own pixels, by two matrix products (a Fourier transform of any sampling).
image = (np.arange(pair.FRAME) - 0.5 * (pair.FRAME - 1)) * pair.PIXEL
kernel = np.exp(-2j * np.pi / (pair.WAVELENGTH * pair.FOCAL_LENGTH) * np.outer(image, x))
amplitude = kernel @ field @ kernel.T
scale = (
    (pitch**2 / (pair.WAVELENGTH * pair.FOCAL_LENGTH)) ** 2
    * pair.PIXEL**2
    / (on_mirror.sum() * pitch**2)
)
psf = np.abs(amplitude) ** 2 * scale
pair.compare("OpticStudio", pair.encircled(pair.scattered(psf, halo)), result, 5e-3)
