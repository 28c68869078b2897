"""The fitted pair in GalSim: the aberrations of an OpticalPSF, the scatter as an interpolated image.

GalSim counts aberrations in waves of the wavefront by Noll's index from 1 (`aberrations[0]` is not used), and
angles in arcsec. Halo and core become one profile, a delta function and an InterpolatedImage.
"""

import galsim
import numpy as np

import pair

result, halo = pair.fitted_pair()
arcsec = np.degrees(pair.PIXEL / pair.FOCAL_LENGTH) * 3600
noll = result.surface.to_noll()
aberrations = np.concatenate([[0.0], 2 * noll / pair.WAVELENGTH])
optical = galsim.OpticalPSF(
    lam=pair.WAVELENGTH * 1e9,
    diam=pair.DIAMETER,
    aberrations=list(aberrations),
    pad_factor=2.0,
    oversampling=2.0,
)
scatter = galsim.InterpolatedImage(
    galsim.Image(np.ascontiguousarray(halo.kernel), scale=arcsec), normalization="flux", flux=halo.halo
)
core = galsim.DeltaFunction(flux=halo.core)
whole = galsim.Convolve(
    optical, galsim.Add(core, scatter), gsparams=galsim.GSParams(maximum_fft_size=16384)
)
image = whole.drawImage(nx=pair.FRAME, ny=pair.FRAME, scale=arcsec, method="no_pixel").array
pair.compare("GalSim", pair.encircled(image), result, 1e-2)
