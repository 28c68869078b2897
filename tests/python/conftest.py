"""What the tests of the Python package share. Run them through `ctest -L python`, or with PYTHONPATH at
build/release/python and ABERFIT at the program."""

import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("ABERFIT", str(ROOT / "build/release/aberfit"))


@pytest.fixture
def program(tmp_path):
    """Runs the program in a folder of its own and returns what it prints."""

    def run(*arguments, codes=(0, 1)):
        done = subprocess.run([PROGRAM, *map(str, arguments)], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode in codes, done.stderr
        return done.stdout

    return run


@pytest.fixture
def small():
    """A study that a fit takes well below a second for."""
    return {
        "aberfit": 1,
        "mirror": {"focal_length": "2 m"},
        "aperture": {"shape": "circle", "diameter": "0.2 m"},
        "light": {"wavelength": "1 um"},
        "roughness": {"psd": {"model": "uniform", "rms": "30 nm", "f_min": "6 /m", "f_max": "30 /m"}},
        "target": {"statistics": {"ee50": {}, "ee80": {}, "strehl": {}}},
        "terms": {"zernike": {"n_max": 12}},
    }
