"""A fitted pair of terms and scatter, and its energies, for the recipes of this folder.

    PYTHONPATH=build/release/python python3 examples/python/pair.py

A fit divides the roughness: frequencies below a cut become terms, the rest scatters. Another program gets the
surface of the terms, and the scatter as a kernel with which its PSF is convolved.
"""

import numpy as np

import aberfit

FOCAL_LENGTH, DIAMETER, WAVELENGTH = 4.0, 0.4, 1e-6  # [m]; an f/10 mirror
STUDY = {
    "aberfit": 1,
    "title": "A pair for other programs",
    "mirror": {"focal_length": FOCAL_LENGTH},
    "aperture": {"shape": "circle", "diameter": DIAMETER},
    "light": {"wavelength": WAVELENGTH},
    "roughness": {
        "psd": {
            "model": "k-correlation",
            "rms": "40 nm",
            "correlation_length": "0.05 m",
            "exponent": 2.5,
            "f_min": "3 /m",
            "f_max": "500 /m",
        }
    },
    "terms": {"band": "20 /m", "zernike": {"n_max": 30}},
}
RADII = np.array([10e-6, 20e-6, 40e-6, 80e-6, 160e-6])  # [m]; an Airy disc ends at 12.2 um
PIXEL = 2e-6  # [m] in the focus: a fifth of lambda f/D
PUPIL = 512  # points across the mirror
FRAME = 1024  # pixels of the image


def fitted_pair():
    """The result of the fit, and its scatter as a kernel of an odd number of pixels."""
    result = aberfit.fit(STUDY)
    cut = 20.0  # [cycles/m], as the study says
    halo = aberfit.ghs(STUDY).halo(PIXEL, FRAME + 1, f_min=cut)
    return result, halo


def energies(result):
    """Our own encircled energies of a result, terms and scatter together, at RADII."""
    return np.interp(RADII, result.radius, result.focus.encircled_energy[list(result.plane).index(0.0)])


def energies_by_rays(surface):
    """Encircled energies of the terms alone by our own rays, at RADII, for programs that trace rays."""
    alone = {
        "target": {"theory": "geometric"},
        "trace": {"model": "rays"},
        "terms": {"band": "all", "zernike": {"n_max": 30}},
    }  # no scatter of the rest
    return energies(aberfit.trace(STUDY | alone, coefficients=surface))


def pupil():
    """Coordinates [m] of the points across the mirror, and which of them are on it."""
    x = (np.arange(PUPIL) - 0.5 * (PUPIL - 1)) * (DIAMETER / PUPIL)
    return x, x[None, :] ** 2 + x[:, None] ** 2 <= (0.5 * DIAMETER) ** 2


def scattered(psf, halo):
    """An image of fractions of the energy, convolved with the kernel."""
    size = psf.shape[0] + halo.kernel.shape[0] - 1
    shape = (size, size)
    product = np.fft.rfft2(psf, shape) * np.fft.rfft2(halo.whole, shape)
    first = halo.kernel.shape[0] // 2
    return np.fft.irfft2(product, shape)[first : first + psf.shape[0], first : first + psf.shape[0]]


def encircled(image, pixel=PIXEL, subpixels=5):
    """Fractions of the energy within RADII of the middle; each pixel counts by the part of it inside."""
    n = image.shape[0]
    x = (np.arange(n) - 0.5 * (n - 1)) * pixel
    offsets = (np.arange(subpixels) - 0.5 * (subpixels - 1)) * (pixel / subpixels)
    result = []
    for radius in RADII:
        share = np.zeros_like(image)
        for dx in offsets:
            for dy in offsets:
                share += (x[None, :] + dx) ** 2 + (x[:, None] + dy) ** 2 <= radius**2
        result.append(float((image * share).sum()) / subpixels**2)
    return np.array(result)


def compare(name, theirs, result, allowed):
    """Prints both energies side by side; fails above `allowed`, a fraction of the energy."""
    ours = energies(result)
    print(f"{name:<12} radius [um]  aberfit  {name}")
    for radius, a, b in zip(RADII, ours, theirs):
        print(f"{'':<12} {radius * 1e6:11.0f}  {a:7.4f}  {b:7.4f}")
    worst = float(np.max(np.abs(theirs - ours)))
    print(f"{'':<12} largest difference {worst:.4f} of the energy, allowed {allowed}")
    if not worst <= allowed:
        raise SystemExit(f"{name} differs by more than {allowed}")


if __name__ == "__main__":
    fitted, scatter = fitted_pair()
    print(fitted)
    print(scatter)
    print(dict(zip(RADII, energies(fitted))))
