"""The functions give what the program gives."""

import concurrent.futures
import inspect
import json
import multiprocessing
import os
import pickle
import re
import threading

import numpy as np
import pytest

import aberfit

ROOT = __import__("conftest").ROOT
CLOCK = re.compile(r'("[a-z_]*(?:seconds|bytes)[a-z_]*": )(?:[0-9.e+-]+|\[[^]]*\])')


def timeless(text):
    """The text without what a clock or the memory of the process says."""
    return re.sub(r"\b[0-9.]+ (s|ms|MB)\b", r"T \1", CLOCK.sub(r"\1T", text))


SCENES = ["terms", "few", "annulus", "band", "rays", "given"]
BUDGETS = {
    "rms": {"for": ["/roughness/psd/rms"], "so_that": {"strehl": ">= 0.8"}},
    "two": {"for": ["/roughness/psd/rms", "/roughness/psd/f_max"], "so_that": {"strehl": ">= 0.8"}},
    "edge": {"for": ["/roughness/psd/f_max"], "so_that": {"ee80_diameter": "<= 5 arcsec", "tis": "<= 0.3"}},
    "sure": {"for": ["/roughness/psd/rms"], "so_that": {"ee80_radius": "<= 20 um"}, "confidence": 0.9},
    "never": {"for": ["/roughness/psd/rms"], "so_that": {"ee80_radius": "<= 1 um"}},
    "ceilings": {"ceilings": {"f_max": "100 /m"}, "so_that": {"strehl": ">= 0.8"}},
}
ESTIMATES = {
    "plain": {},
    "line": {"degree": 1},
    "ellipse": {"detrend": "ellipse"},
    "window": {"window": "welch"},
    "family": {"family": "k-correlation"},
    "cut": {"f_min": "5 /m", "f_max": "100 /m", "bins_per_decade": 8},
}
STUDIES = {
    "fit": SCENES,
    "check": SCENES,
    "trace": SCENES,
    "verify": SCENES,
    "solve": BUDGETS,
    "psd": ESTIMATES,
}


def study_of(name, small):
    study = {**json.loads(json.dumps(small)), "verify": {"draws": 16}}
    if name == "few":
        study["terms"] = {"zernike": {"n_max": 6}, "band": "all"}
    if name == "annulus":
        study["aperture"] = {"shape": "annulus", "diameter": "0.2 m", "inner_diameter": "60 mm"}
    if name == "band":
        study["terms"] = {"zernike": {"n_max": 10}, "band": "15 /m"}
    if name == "rays":
        study["target"] = {"theory": "geometric", "statistics": {"ee50": {}, "ee80": {}}}
    if name == "given":
        study["target"] = {"statistics": {"ee80": {"value": "20 um"}}}
    if name in BUDGETS:
        study["solve"] = BUDGETS[name]
    if name in ESTIMATES:
        profile = ROOT / "fits/measured-turning-lines/turned.txt"
        study["roughness"]["psd"] = {"model": "measured", "file": str(profile), **ESTIMATES[name]}
    return study


# Three studies of each command in the daily tests; all of them with ABERFIT_ALL set.
CASES = [
    (c, n) for c, names in STUDIES.items() for n in list(names)[: 6 if "ABERFIT_ALL" in os.environ else 3]
]


@pytest.mark.parametrize("command, name", CASES)
def test_python_and_program_give_the_same_bytes(command, name, small, program, tmp_path):
    path = tmp_path / "study.json"
    path.write_text(json.dumps(study_of(name, small)))
    printed = program(
        command,
        path,
        "--json",
        "--quiet",
        *([] if command in ("check", "trace") else ["-o", "out"]),
        *(["--pictures", "none"] if command not in ("check", "trace") else []),
    )
    found = getattr(aberfit, command)(path)
    assert timeless(found.json) == timeless(printed)
    assert found.headline == json.loads(printed).get("headline", "")


def test_a_dict_and_a_file_give_the_same_numbers(small, tmp_path):
    path = tmp_path / "study.json"
    path.write_text(json.dumps(small))
    by_file, by_dict = aberfit.fit(path), aberfit.fit(small)
    assert by_file["coefficients"] == by_dict["coefficients"]
    changed = aberfit.fit(path, changes={"/roughness/psd/rms": "20 nm"})
    assert changed["scene"]["rms_height_m"] == pytest.approx(20e-9)


def test_saved_files_are_those_of_the_program(small, program, tmp_path):
    path = tmp_path / "study.json"
    path.write_text(json.dumps(small))
    program("fit", path, "-o", tmp_path / "theirs", "--quiet", "--arrays", "csv")
    result = aberfit.fit(path)
    result.save(tmp_path / "ours", arrays="csv")
    names = sorted(
        f.relative_to(tmp_path / "theirs") for f in (tmp_path / "theirs").rglob("*") if f.is_file()
    )
    assert names == sorted(
        f.relative_to(tmp_path / "ours") for f in (tmp_path / "ours").rglob("*") if f.is_file()
    )
    for name in ("coefficients.csv", "result.json", "summary.txt", "arrays/encircled_energy.csv"):
        ours, theirs = (
            timeless((tmp_path / whose / name).read_text()).split() for whose in ("ours", "theirs")
        )
        assert ours == theirs  # lines of a summary break elsewhere where a time is shorter
    with pytest.raises(aberfit.InputError):
        (tmp_path / "full").mkdir()
        (tmp_path / "full" / "result.json").write_text("mine")
        result.save(tmp_path / "full")


def map_of(height, pitch):
    n = height.shape[0]
    x = (np.arange(n) - 0.5 * (n - 1)) * pitch
    return np.where(x[None, :] ** 2 + x[:, None] ** 2 <= (0.5 * n * pitch) ** 2, height, np.nan)


def test_a_map_in_memory_is_like_its_file(small, program, tmp_path):
    random = np.random.default_rng(5)
    n, pitch = 64, 0.2 / 64
    x = (np.arange(n) - 0.5 * (n - 1)) * pitch
    waves = sum(
        random.normal() * np.cos(2 * np.pi * (fx * x[None, :] + fy * x[:, None]) + random.uniform(0, 7))
        for fx, fy in random.uniform(-20, 20, (12, 2))
    )
    height = map_of(30e-9 * waves, pitch)
    np.save(tmp_path / "map.npy", height)
    study = {
        **small,
        "roughness": None,
        "target": {
            "map": {
                "file": "map.npy",
                "pitch": pitch,
                "value_unit": "m",
                "of": "surface",
                "first_row": "bottom",
            }
        },
    }
    del study["roughness"]
    path = tmp_path / "study.json"
    path.write_text(json.dumps(study))
    printed = json.loads(program("fit", path, "--json", "--quiet", "-o", "out", "--pictures", "none"))
    found = aberfit.fit(study, map=aberfit.Map(height, pitch))
    for key in ("coefficients", "map", "scene"):
        assert json.dumps(found.document.get(key)) == json.dumps(printed.get(key)), key


def fits_images(path):
    """Images of doubles of a FITS file with their cards: a reader of its own."""
    content, at, images = path.read_bytes(), 0, []
    while at < len(content):
        cards = {}
        while "END" not in cards:
            for k in range(at, at + 2880, 80):
                card = content[k : k + 80].decode()
                cards[card[:8].strip()] = card[10:].split("/")[0].strip(" '")
            at += 2880
        rows, columns = int(cards["NAXIS2"]), int(cards["NAXIS1"])
        kind = {"-64": ">f8", "8": "u1", "16": ">i2"}[cards["BITPIX"]]
        image = np.frombuffer(content, kind, rows * columns, at).reshape(rows, columns)
        at += -(-image.nbytes // 2880) * 2880
        images.append((cards, image))
    return images


def test_a_map_in_memory_is_like_its_fits_file(small, program, tmp_path):
    surface = aberfit.Surface(radius=0.1, zernike={(2, 0): 40e-9, (3, 1): -25e-9, (7, -3): 8e-9})
    file = surface.write(tmp_path, "fits-opd", npix=97)
    (cards, path_difference), (_, mask) = fits_images(file)
    height = np.where(mask != 0, 0.5 * path_difference.astype(float), np.nan)
    study = {key: small[key] for key in ("aberfit", "mirror", "aperture", "light")}
    study["target"] = {"map": {"file": "opd.fits", "origin": "grid"}}
    study["terms"] = {"zernike": {"n_min": 0, "n_max": 8}}
    path = tmp_path / "study.json"
    path.write_text(json.dumps(study))
    printed = json.loads(program("fit", path, "--json", "--quiet", "-o", "out", "--pictures", "none"))
    found = aberfit.fit(path, map=aberfit.Map(height, float(cards["PIXELSCL"])))
    for key in ("coefficients", "map", "scene"):
        assert json.dumps(found.document.get(key)) == json.dumps(printed.get(key)), key
    assert found.surface.zernike[(3, 1)] == pytest.approx(
        -25e-9, abs=2e-11
    )  # rows and columns are in place
    assert found.surface.zernike[(7, -3)] == pytest.approx(8e-9, abs=2e-11)
    masked = np.ma.array(np.where(np.isnan(height), 1e-3, height), mask=np.isnan(height))
    masked = aberfit.fit(path, map=aberfit.Map(masked, float(cards["PIXELSCL"])))
    assert masked["coefficients"] == found["coefficients"]


def test_a_profile_in_memory_is_like_its_file(program, tmp_path, small):
    random = np.random.default_rng(7)
    x = np.arange(1000) * 1e-3
    height = np.cumsum(np.cumsum(random.normal(size=1000)) * 1e-12)
    np.savetxt(tmp_path / "profile.txt", np.column_stack([x, height]), fmt="%.17g", header="x_m height_m")
    psd = {
        "model": "measured",
        "file": "profile.txt",
        "quantity": "height",
        "of": "surface",
        "x_unit": "m",
        "value_unit": "m",
    }
    study = {**small, "roughness": {"psd": psd}}
    path = tmp_path / "study.json"
    path.write_text(json.dumps(study))
    printed = json.loads(program("psd", path, "--json", "--quiet", "-o", "out", "--pictures", "none"))
    found = aberfit.psd(study, profile=aberfit.Profile(x, height))
    for key in ("roughness", "fit", "estimate", "bins"):
        assert found.document.get(key) == printed.get(key), key


def test_errors_say_where_and_what(small):
    small["mirror"]["focal_lenght"] = small["mirror"].pop("focal_length")
    with pytest.raises(aberfit.InputError) as caught:
        aberfit.check(small)
    assert caught.value.pointer == "/mirror/focal_lenght"
    assert "focal_length" in caught.value.allowed
    assert isinstance(caught.value, ValueError)
    with pytest.raises(aberfit.InputError, match="place"):
        aberfit.check(small | {"mirror": {"focal_length": 2}}, map=aberfit.Map(np.zeros((4, 4)), 1e-3))
    with pytest.raises(aberfit.InputError, match="none, npz|npz"):
        aberfit.check(small | {"mirror": {"focal_length": 2}}, arrays="hdf5")


def test_arrays_are_those_of_the_program_and_outlive_their_result(small, program, tmp_path):
    path = tmp_path / "study.json"
    path.write_text(json.dumps(small))
    program("fit", path, "-o", tmp_path / "out", "--quiet", "--pictures", "none", "--arrays", "npz")
    theirs = np.load(tmp_path / "out" / "arrays.npz")
    result = aberfit.fit(path)
    psf, energy, radius = result.focus.psf, result.focus.encircled_energy, result.radius
    mtf = result.theory.mtf
    del result
    assert not psf.flags.writeable and not psf.flags.owndata
    np.testing.assert_array_equal(radius, theirs["ee_radius_m"])
    np.testing.assert_array_equal(psf, theirs["psf_surface_per_m2"])
    np.testing.assert_array_equal(energy, theirs["ee_surface"])
    np.testing.assert_array_equal(mtf, theirs["mtf_theory"])


def test_two_threads_give_what_each_gives_alone(small):
    studies = [small, small | {"fit": {"seed": 2}}]
    alone = [aberfit.fit(study, threads=1)["coefficients"] for study in studies]
    together = [None, None]

    def work(k):
        together[k] = aberfit.fit(studies[k], threads=1)["coefficients"]

    threads = [threading.Thread(target=work, args=(k,)) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert together == alone


def test_progress_is_told_and_its_exceptions_arrive(small):
    class Enough(Exception):
        pass

    def stop(line):
        raise Enough(line)

    slow = small | {"terms": {"zernike": {"n_max": 60}}, "target": {}}
    with pytest.raises(Enough):
        aberfit.fit(slow, progress=stop)


def test_a_sweep_gives_each_case(small):
    study = small | {"vary": {"over": {"/roughness/psd/rms": ["10 nm", "20 nm"]}, "run": "check"}}
    seen = list(aberfit.sweep(study))
    assert [values["/roughness/psd/rms"] for values, _ in seen] == ["10 nm", "20 nm"]
    assert [result["scene"]["rms_height_m"] for _, result in seen] == pytest.approx([10e-9, 20e-9])


def test_a_sweep_keeps_changes_and_results_apart(small, tmp_path):
    study = small | {"vary": {"over": {"/roughness/psd/rms": ["10 nm", "20 nm"]}, "run": "trace"}}
    seen = list(
        aberfit.sweep(study, changes={"/mirror/focal_length": "5 m", "/title": "5"}, output=tmp_path)
    )
    assert all(result["study"]["mirror"]["focal_length"] == 5.0 for _, result in seen)
    assert [(tmp_path / folder / "result.json").exists() for folder in ("0001", "0002")] == [True, True]


def test_check_writes_where_it_is_told(small, tmp_path):
    aberfit.check(small, output=tmp_path / "out")
    assert (tmp_path / "out" / "report.html").exists()
    with pytest.raises(aberfit.InputError):
        aberfit.check(small).save(None)
    with pytest.raises(aberfit.InputError):
        aberfit.check(small, threads=-1)
    assert aberfit.check(small).coefficients is None


def test_results_show_themselves(small, tmp_path):
    result = aberfit.fit(small)
    assert "ee80" in str(result) and result.headline in str(result).replace("\n", " ")
    assert "<table" in result._repr_html_() and "<html" not in result._repr_html_()
    result.report(tmp_path / "page.html")
    assert "<html" in (tmp_path / "page.html").read_text()
    assert result.verdict == result["equivalence"]["verdict"]
    assert dict(result) == result.document and "coefficients" in result
    assert "threads" in inspect.signature(aberfit.check).parameters
    assert list(inspect.signature(aberfit.trace).parameters)[:2] == ["study", "coefficients"]


def test_scatter_beside_the_terms_is_that_of_the_files(small, tmp_path):
    result = aberfit.fit(small | {"terms": {"band": "15 /m", "zernike": {"n_max": 12}}})
    result.save(tmp_path / "out")
    lines = [line for line in open(tmp_path / "out" / "scatter.csv") if not line.startswith("#")]
    table = np.array([line.split(",") for line in lines[1:]], dtype=float)
    found = result.scatter
    np.testing.assert_allclose(
        table[:, [0, 2, 3]].T, [found.theta, found.bsdf, found.tis_within], rtol=1e-8
    )
    assert result.halo.halo + result.halo.beyond == pytest.approx(found.tis_within[-1], rel=1e-9)
    theory = aberfit.ghs(small).bsdf(found.theta, f_min=15)
    np.testing.assert_allclose(found.bsdf, theory, rtol=1e-9)
    assert aberfit.fit(small).scatter is None


@pytest.mark.parametrize("command", [aberfit.fit, aberfit.check])
def test_an_image_on_coarse_pixels_is_the_sum_of_fine_ones(small, command):
    result = command(small | {"terms": {"band": "15 /m", "zernike": {"n_max": 12}}})
    fine, coarse = result.image(2e-6, 99), result.image(22e-6, 9)
    # The correction for light that the pupil grid folds is taken in the middle of each pixel.
    np.testing.assert_allclose(coarse, fine.reshape(9, 11, 9, 11).sum(axis=(1, 3)), atol=1e-5)
    step = result.pixel[1] - result.pixel[0]
    frame = result.image(step, result.pixel.size) / step**2
    np.testing.assert_allclose(frame, result.psf, rtol=1e-6, atol=1e-9 * frame.max())
    assert result.image(1e-4, 5, dz=1e-3).sum() == pytest.approx(1, abs=0.1)
    with pytest.raises(aberfit.InputError):
        result.image(-1, 5)
    with pytest.raises(aberfit.InputError, match="focal length"):
        result.image(2.1, 5)


def test_tables_are_data_frames(small):
    pytest.importorskip("pandas")
    fitted, checked = aberfit.fit(small), aberfit.check(small)
    metrics = fitted.to_frame()
    assert list(metrics.index) == [row["name"] for row in fitted["equivalence"]["metrics"]]
    assert metrics.loc["strehl", "target"] == fitted["target"]["strehl"]["value"]
    assert checked.to_frame().loc["strehl", "value"] == checked["target"]["strehl"]["value"]
    compared = aberfit.verify(small | {"verify": {"draws": 16}})
    decides = compared["light"] if compared["decided_by"] == "light" else compared
    assert list(compared.to_frame().index) == list(decides["statistics"])
    traced = aberfit.trace(small, coefficients=fitted.surface)
    assert traced.to_frame().loc["strehl", "value"] == traced["statistics"]["strehl"]
    goal = {"for": ["/roughness/psd/rms"], "so_that": {"strehl": ">= 0.8"}}
    assert list(aberfit.solve(small | {"solve": goal}).to_frame().index) == ["strehl"]
    x = np.linspace(0, 0.5, 1000)
    measured = {"psd": {"model": "measured", "file": "scan", "of": "surface"}}
    profile = aberfit.Profile(x, np.cumsum(np.random.default_rng(3).normal(size=x.size)) * 1e-10)
    octaves = aberfit.psd(small | {"roughness": measured}, profile=profile)
    assert octaves.to_frame()["data.rms_height_m"][0] == octaves["octaves"][0]["data"]["rms_height_m"]


def test_results_and_surfaces_go_to_other_processes(small):
    result = aberfit.fit(small)
    with concurrent.futures.ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        there = pool.submit(aberfit.fit, small).result()
        with pytest.raises(aberfit.InputError) as caught:
            pool.submit(aberfit.fit, small | {"mirror": {}}).result()
    assert caught.value.pointer == "/mirror/focal_length"
    assert there["coefficients"] == result["coefficients"] and str(there) and there._repr_html_()
    np.testing.assert_array_equal(there.focus.psf, result.focus.psf)
    assert there.surface == result.surface != aberfit.Surface(radius=0.1, noll=[1e-9])
    with pytest.raises(aberfit.InputError, match="pickled"):
        there.save("out")
    light = pickle.loads(pickle.dumps(aberfit.ghs(small)))
    assert light.tis == aberfit.ghs(small).tis
