"""Surfaces of terms against closed forms and against other readers."""

import numpy as np
import pytest

import aberfit

R = 0.25


def test_values_are_those_of_closed_forms():
    a, b = 20e-9, -7e-9
    surface = aberfit.Surface(radius=R, zernike={(2, 0): a, (3, 1): b})
    x, y = np.array([0.0, 0.1, 0.2]), np.array([0.05, -0.1, 0.1])
    r2 = (x**2 + y**2) / R**2
    defocus = np.sqrt(3) * (2 * r2 - 1)
    coma = np.sqrt(8) * (3 * r2 - 2) * x / R
    np.testing.assert_allclose(surface.heights(x, y), a * defocus + b * coma, rtol=1e-13, atol=1e-22)
    step = 1e-6
    slope = (surface.heights(x + step, y) - surface.heights(x - step, y)) / (2 * step)
    np.testing.assert_allclose(surface.slopes(x, y)[0], slope, rtol=1e-6)
    assert surface.rms() == pytest.approx(np.hypot(a, b), rel=1e-12)


def test_waves_and_powers():
    surface = aberfit.Surface(radius=R, fourier=[(10, 0, 1e-9, 2e-9)], spherical={4: 3e-9})
    x = np.linspace(-0.2, 0.2, 7)
    wave = 1e-9 * np.cos(20 * np.pi * x) + 2e-9 * np.sin(20 * np.pi * x)
    np.testing.assert_allclose(surface.heights(x, 0.0), wave + 3e-9 * (x / R) ** 4, atol=1e-20)
    assert surface.coefficients.tolist() == [1e-9, 2e-9, 3e-9]


def test_indices_and_norms():
    noll = aberfit.Surface(radius=R, noll=[0, 0, 0, 1e-9, 0, 2e-9])  # defocus is 4, cosine astigmatism 6
    assert noll.zernike[(2, 0)] == 1e-9 and noll.zernike[(2, 2)] == 2e-9
    np.testing.assert_array_equal(noll.to_noll()[[3, 5]], [1e-9, 2e-9])
    osa = noll.to_osa()
    assert osa[4] == 1e-9 and osa[5] == 2e-9  # (n (n + 2) + m)/2
    fringe = noll.to_fringe()
    assert fringe[3] == pytest.approx(np.sqrt(3) * 1e-9) and fringe[4] == pytest.approx(np.sqrt(6) * 2e-9)
    again = aberfit.Surface(radius=R, fringe=fringe)
    assert again.zernike[(2, 2)] == pytest.approx(2e-9, rel=1e-15)
    assert aberfit.Surface(radius=R, osa=osa).zernike == {
        k: noll.zernike.get(k, 0.0) for k in again.zernike
    }


def test_psd_integrates_to_the_variance():
    surface = aberfit.Surface(radius=R, zernike={(6, 2): 5e-9, (9, -3): 4e-9})
    f = np.geomspace(0.01, 400, 4000)
    f, s = surface.psd(f)
    variance = np.trapz(2 * np.pi * f * s, f)
    assert variance == pytest.approx(surface.rms() ** 2, rel=0.02)  # the tail beyond 400 /m is left out


@pytest.mark.parametrize("format", aberfit.Surface.formats())
def test_every_format_is_written_and_read_back(format, tmp_path):
    surface = aberfit.Surface(radius=R, zernike={(2, 0): 20e-9, (3, 1): -7e-9, (4, -2): 3e-9})
    path = surface.write(tmp_path, format, npix=65)
    if format == "coefficients-csv":
        assert aberfit.Surface.read(path).zernike == surface.zernike
    elif format == "codev-zfr":
        read = aberfit.Surface.read(path, radius=R)
        for mode, a in surface.zernike.items():
            assert read.zernike[mode] == pytest.approx(a, rel=1e-5)
    elif format in ("codev-int", "zemax-grid-sag", "fits-opd"):
        study = {
            "aberfit": 1,
            "mirror": {"focal_length": 2},
            "aperture": {"shape": "circle", "diameter": 1.9 * R},
            "light": {"wavelength": 632.8e-9},
            "terms": {"zernike": {"n_min": 0, "n_max": 4}},
            "target": {"map": {"file": str(path), "origin": "grid"}},
        }
        if format == "codev-int":
            study["target"]["map"]["pitch"] = 2 * R / 64
        found = aberfit.fit(study).surface
        x, y = np.array([0.05, -0.1, 0.0]), np.array([0.1, 0.05, -0.15])
        np.testing.assert_allclose(found.heights(x, y), surface.heights(x, y), atol=2e-10)
    else:
        assert path.stat().st_size > 100


def test_a_surface_is_traced(small, tmp_path):
    surface = aberfit.Surface(radius=0.1, zernike={(2, 2): 100e-9})
    by_surface = aberfit.trace(small, coefficients=surface)
    by_random = aberfit.trace(small)
    assert by_surface["statistics"] != by_random["statistics"]
    path = surface.write(tmp_path, "coefficients-csv")
    by_file = aberfit.trace(small, coefficients=path)
    path.unlink()
    assert by_file["statistics"] == by_surface["statistics"]
    np.testing.assert_array_equal(by_file.focus.psf, by_surface.focus.psf)


def test_refuses_what_cannot_be():
    with pytest.raises(ValueError):
        aberfit.Surface(radius=R, zernike={(2, 1): 1e-9})
    surface = aberfit.Surface(radius=R, zernike={(2, 0): 1e-9})
    for call in (
        lambda: surface.write("x", "stl"),
        lambda: surface.rms(inner_radius=R),
        lambda: surface.grid(0),
        lambda: surface.grid(True),
        lambda: surface.psd(-1.0),
        lambda: surface.psd(1e12),
        lambda: aberfit.Surface(radius=R, fourier=[(1, 0, 1e-9, 0)]).psd(npix=10**9),
        lambda: surface.write("x", "fits-opd", npix=10**6),
        lambda: surface.write("x", "codev-int", wavelength=-1),
        lambda: surface.heights("a", 0),
        lambda: aberfit.Surface(radius=R, noll={0: 1e-9}),
        lambda: aberfit.Surface(radius=R, fourier=[(1, 2, 3)]),
        lambda: aberfit.Surface(radius=-1),
        lambda: aberfit.Surface(radius=R, zernike={(10**12, 0): 1e-9}),
        lambda: aberfit.Surface(radius=R, zernike={(2, 0): float("nan")}),
        lambda: aberfit.Surface(radius=R, spherical={2: 1e-9}),
    ):
        with pytest.raises(aberfit.InputError, match="allowed"):
            call()
    with pytest.raises(TypeError):
        aberfit.Surface(radius=R, zernike={(2.5, 0.5): 1e-9})
    assert aberfit.Surface(radius=R, noll={4: 1e-9}) == aberfit.Surface(radius=R, zernike={(2, 0): 1e-9})
    both = [0, 0, 0, 1e-9]
    assert aberfit.Surface(radius=R, noll=both, fringe=both).to_noll()[3] == pytest.approx(
        1e-9 + 1e-9 / 3**0.5
    )
    assert aberfit.Surface(radius=np.array(R), fringe={4: 1e-9}).to_fringe()[3] == pytest.approx(1e-9)
    assert surface.psd(0.0)[1][0] >= 0
    height = surface.heights([0.0, 0.1], 0.0)
    height[0] = 0.0  # it is the caller's
