"""The scripts of examples/python: notebooks run as they are, recipes run where their program is installed."""

import importlib.util
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import aberfit

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples/python"
NOTEBOOKS = ["specification_to_terms", "measured_mirror", "budget_and_sweep"]
RECIPES = {
    "to_prysm": "prysm",
    "to_poppy": "poppy",
    "to_hcipy": "hcipy",
    "to_galsim": "galsim",
    "to_batoid": "batoid",
    "to_optiland": "optiland.psf",
    "to_rayoptics": "rayoptics.optical.opticalmodel",
    "to_opticstudio": "numpy",
}

# Takes every call in place of matplotlib, where that is not installed.
STAND_IN = """
class Anything:
    def __getattr__(self, name): return Anything()
    def __call__(self, *arguments, **options): return Anything()
def subplots(rows=1, columns=1, **options):
    return Anything(), Anything() if rows * columns == 1 else [Anything()] * (rows * columns)
"""


def run(script, folder, **environment):
    paths = [os.environ.get("PYTHONPATH", ""), str(EXAMPLES), *environment.pop("paths", [])]
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / f"{script}.py")],
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths), "MPLBACKEND": "Agg", **environment},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("script", NOTEBOOKS)
def test_notebook_runs(script, tmp_path):
    paths = []
    if importlib.util.find_spec("matplotlib") is None:
        stand_in = tmp_path / "stand_in" / "matplotlib"
        stand_in.mkdir(parents=True)
        (stand_in / "__init__.py").write_text("")
        (stand_in / "pyplot.py").write_text(STAND_IN)
        paths.append(str(stand_in.parent))
    (tmp_path / "out").mkdir()
    run(script, tmp_path / "out", paths=paths)


@pytest.mark.parametrize("script, needs", RECIPES.items())
def test_recipe_agrees(script, needs, tmp_path):
    pytest.importorskip(needs)
    run(script, tmp_path)


def test_the_pair_of_the_recipes_is_what_the_table_says():
    """Where a program is not installed, its page still tells the truth: the committed energies are ours."""
    sys.path.insert(0, str(EXAMPLES))
    try:
        import pair
    finally:
        sys.path.pop(0)
    result, halo = pair.fitted_pair()
    table = [
        line.split("|")
        for line in (EXAMPLES / "README.md").read_text().splitlines()
        if line.startswith("| aberfit |")
    ]
    said = np.array([float(cell) for cell in table[0][2:7]])
    np.testing.assert_allclose(pair.energies(result), said, atol=2e-3)
    assert halo.core + halo.halo + halo.beyond == pytest.approx(1, abs=1e-9)
    assert result.verdict == "equivalent"
    x, on_mirror = pair.pupil()
    assert on_mirror.sum() == pytest.approx(np.pi / 4 * pair.PUPIL**2, rel=1e-3)
    assert isinstance(result.surface, aberfit.Surface)
