"""The fitted pair in POPPY: the surface as a FITS file of optical path differences.

POPPY takes metres of optical path, pixels of `PIXELSCL` metres in the pupil and arcsec in the image. The file
opd.fits has all of them; the convolution with the scatter is ours.
"""

import tempfile

import astropy.units as u
import numpy as np
import poppy

import pair

result, halo = pair.fitted_pair()
with tempfile.TemporaryDirectory() as folder:
    path = result.surface.write(folder, "fits-opd", wavelength=pair.WAVELENGTH, npix=pair.PUPIL + 1)
    scale = np.degrees(pair.PIXEL / pair.FOCAL_LENGTH) * 3600  # [arcsec]
    system = poppy.OpticalSystem(npix=pair.PUPIL, oversample=1, pupil_diameter=pair.DIAMETER * u.m)
    system.add_pupil(poppy.CircularAperture(radius=0.5 * pair.DIAMETER, gray_pixel=False))
    system.add_pupil(poppy.FITSOpticalElement(opd=str(path), planetype=poppy.poppy_core.PlaneType.pupil))
    system.add_detector(pixelscale=scale, fov_pixels=pair.FRAME)
    psf = system.calc_psf(pair.WAVELENGTH, normalize="exit_pupil")[0].data
pair.compare("POPPY", pair.encircled(pair.scattered(psf, halo)), result, 5e-3)
