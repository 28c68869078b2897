"""Theory alone against closed forms and direct sums."""

import json
import pickle

import numpy as np
import pytest

import aberfit

BLOCK = {"model": "gaussian", "rms": "20 nm", "correlation_length": "5 mm"}
SCENE = dict(focal_length="2 m", diameter="0.2 m", wavelength="632.8 nm")


def test_psd_of_a_gaussian_is_its_closed_form():
    psd = aberfit.Psd(**BLOCK)
    f = np.array([0.0, 10.0, 100.0])
    closed = np.pi * 5e-3**2 * 20e-9**2 * np.exp(-((np.pi * 5e-3 * f) ** 2))
    np.testing.assert_allclose(psd(f), closed, rtol=1e-13)
    assert psd.rms() == pytest.approx(20e-9, rel=1e-12)
    assert psd.rms_slope() == pytest.approx(np.sqrt(2) * 20e-9 / 5e-3, rel=1e-12)
    np.testing.assert_allclose(psd.autocorrelation(5e-3), 20e-9**2 * np.exp(-1), rtol=1e-11)
    np.testing.assert_allclose(psd.structure_function(5e-3), 2 * 20e-9**2 * (1 - np.exp(-1)), rtol=1e-11)
    assert set(aberfit.psd_models()) >= {"uniform", "k-correlation", "power-law", "gaussian", "sum"}


def test_light_agrees_with_itself():
    light = aberfit.ghs(**SCENE, psd=BLOCK)
    assert light.tis == pytest.approx(
        1 - np.exp(-((4 * np.pi * 20e-9 / 632.8e-9) ** 2)), rel=1e-3
    )  # slopes shorten it
    radius = light.encircled_energy_radius([0.5, 0.8])
    np.testing.assert_allclose(light.encircled_energy(radius), [0.5, 0.8], rtol=1e-10)
    r = np.linspace(0, radius[1], 4001)
    energy = np.trapz(2 * np.pi * r * light.irradiance(r), r)
    assert energy == pytest.approx(0.8, rel=1e-5)
    assert light.otf([0.0])[0] == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize("pixel", [0.5e-6, 5e-6, 200e-6])
def test_pixels_of_any_size_hold_the_light_of_their_squares(pixel):
    # The energy in a square is that within its edge, averaged over directions.
    light = aberfit.ghs(**SCENE, psd=BLOCK)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    to_edge = 0.5 / np.cos(np.pi / 8 * (nodes + 1))
    for npix in (1, 32, 33):
        square = 0.5 * np.sum(weights * light.encircled_energy(npix * pixel * to_edge))
        assert light.psf(pixel, npix).sum() == pytest.approx(square, abs=2e-6)


@pytest.mark.parametrize("npix", [64, 65])
def test_the_halo_is_the_integral_of_the_scatter(npix):
    light = aberfit.ghs(**SCENE, psd=BLOCK)
    pixel = 20e-6
    halo = light.halo(pixel, npix)
    assert halo.core + halo.halo + halo.beyond == pytest.approx(1, abs=1e-12)
    assert halo.kernel.sum() == pytest.approx(halo.halo, abs=1e-12)
    # Each pixel against a direct sum of the BSDF over its area, on a grid of direction cosines.
    fine = 9
    sub = ((np.arange(npix * fine) + 0.5) / fine - 0.5 * npix) * pixel / 2.0
    sine = np.hypot(sub[None, :], sub[:, None])
    density = light.bsdf(np.arcsin(np.minimum(sine, 1.0)))
    direct = density.reshape(npix, fine, npix, fine).sum(axis=(1, 3)) * (pixel / 2.0 / fine) ** 2
    np.testing.assert_allclose(halo.kernel, direct, atol=2e-6)
    np.testing.assert_array_equal(halo.kernel, halo.kernel.T)
    np.testing.assert_array_equal(halo.kernel, halo.kernel[::-1, ::-1])


def test_the_halo_of_a_band_accounts_for_all_light():
    light = aberfit.ghs(
        **SCENE,
        psd={"model": "power-law", "rms": "10 nm", "exponent": 2.5, "f_min": "5 /m", "f_max": "5000 /m"},
    )
    for f_min in (0.0, 40.0):
        wide, narrow = light.halo(50e-6, 257, f_min=f_min), light.halo(50e-6, 65, f_min=f_min)
        for halo in (wide, narrow):
            assert halo.core + halo.halo + halo.beyond == pytest.approx(1, abs=1e-6)
            assert halo.kernel.min() >= -1e-12
        assert wide.kernel[96:161, 96:161].sum() == pytest.approx(narrow.halo, abs=1e-9)
        # The energies in the largest circle in the frame and in the smallest around it bracket the halo.
        half = 50e-6 * 257 / 2 / 2.0
        inside, around = (
            light.scattered_within(np.arcsin(s), f_min=f_min) for s in (half, half * np.sqrt(2))
        )
        assert inside <= wide.halo <= around


def test_a_study_may_stand_for_the_scene(small, tmp_path):
    light = aberfit.ghs(small)
    assert light.study is small and 0 < light.tis < 1
    path = tmp_path / "study.json"
    path.write_text(json.dumps(small))
    assert aberfit.ghs(path).tis == light.tis
    x = np.arange(2000) * 0.5e-3
    profile = aberfit.Profile(x, np.cumsum(np.random.default_rng(1).normal(size=x.size)) * 1e-10)
    measured = {"model": "measured", "file": "scan"}
    by_scene = aberfit.ghs(**SCENE, psd=measured, profile=profile)
    found = aberfit.psd(small | {"roughness": {"psd": measured}}, profile=profile)
    assert by_scene.g == pytest.approx(aberfit.ghs(**SCENE, psd=found["roughness"]["psd"]).g, rel=1e-9)
    assert pickle.loads(pickle.dumps(by_scene)).g == by_scene.g
    with pytest.raises(aberfit.InputError):
        aberfit.ghs({k: v for k, v in small.items() if k != "roughness"})


def test_refuses_what_has_no_meaning_and_keeps_what_is_unknown():
    light, psd = aberfit.ghs(**SCENE, psd=BLOCK), aberfit.Psd(**BLOCK)
    for call in (
        lambda: light.psf(1e-6, 0),
        lambda: light.psf(0, 8),
        lambda: light.psf(float("nan"), 8),
        lambda: light.halo(1e-6, -3),
        lambda: light.halo(1e-6, 8, f_min=5, f_max=2),
        lambda: light.encircled_energy(-1e-5),
        lambda: light.irradiance(float("inf")),
        lambda: light.psf(3.0, 8),
        lambda: light.encircled_energy_radius(50),
        lambda: light.scattered_within(np.pi),
        lambda: light.encircled_energy(1e-5, dz="1 mm"),
        lambda: light.otf(1j),
        lambda: aberfit.ghs(light.study, psd=BLOCK),
        lambda: psd.rms(5, 2),
        lambda: aberfit.Psd(model="gaussian", rms=float("nan"), correlation_length=1),
    ):
        with pytest.raises(aberfit.InputError):
            call()
    with pytest.raises(aberfit.InputError, match="found a object"):
        aberfit.ghs(**SCENE, psd=object())
    masked = np.ma.array([1e-5, 2e-5], mask=[False, True])
    assert np.isnan(light.encircled_energy(masked)).tolist() == [False, True]
    assert np.isnan(light.encircled_energy(np.nan)) and np.isnan(psd([1.0, np.nan])).tolist() == [
        False,
        True,
    ]
    assert isinstance(psd(3.0), float) and isinstance(light.encircled_energy(1e-5), float)
    assert light.otf(-1e3) == light.otf(1e3)
    # The example of the docstring, with numbers of NumPy.
    assert aberfit.Psd(
        model="k-correlation", rms="20 nm", correlation_length=np.float32(0.2), exponent=2.5, f_max="1 /mm"
    ).rms() == pytest.approx(20e-9)
