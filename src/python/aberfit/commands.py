"""The commands of the program as functions."""

from __future__ import annotations

import functools
import inspect
import json
import os

from . import _aberfit
from .checks import path_text, positive, refuse, whole
from .data import study_text
from .result import Result
from .surface import Surface


def _settings(output=None, pictures=None, arrays=None, force=False, threads=None, call=""):
    settings = _aberfit.Settings()
    settings.output = path_text("output", output) if output is not None else ""
    settings.pictures = str(pictures or "")
    settings.arrays = str(arrays or "")
    settings.force = bool(force)
    settings.threads = 0 if threads is None else whole("threads", threads, 65536)
    settings.call = call
    return settings


def _run(command, study, *, profile=None, map=None, mask=None, changes=None, progress=None, **options):
    """Runs a command. See `fit` for the arguments that all commands have."""
    if progress is not None and not callable(progress):
        refuse("progress", repr(progress), "a function of a line of text, e.g. print")
    seconds = options.pop("seconds", None)
    coefficients = options.pop("coefficients", None)
    settings = _settings(call=f"aberfit.{command} of Python", **options)
    if seconds is not None:
        settings.chart_seconds = positive("seconds", seconds)
    if isinstance(coefficients, Surface):
        settings.set_surface(coefficients._terms)
    elif coefficients is not None:
        settings.coefficients = path_text("coefficients", coefficients)
    text = study_text(study, changes, profile, map, mask)
    surface = coefficients if isinstance(coefficients, Surface) else None
    return Result(_aberfit.run(command, text, settings, progress), settings.threads, surface)


def fit(
    study,
    *,
    profile=None,
    map=None,
    mask=None,
    changes=None,
    output=None,
    pictures=None,
    arrays=None,
    force=False,
    threads=None,
    progress=None,
) -> Result:
    """Finds the equivalent aberration terms of a study and judges them.

    study: a dict, or the path of a study file (JSON or JSONC).
    profile, map, mask: an aberfit.Profile, an aberfit.Map and a matrix in place of the files that the study
        names; the `file` of the study is then only a name.
    changes: values to set in the study first, {"/json/pointer": value}.
    output: a folder for the files that the program writes; absent: nothing is written.
    pictures: "auto", "svg", "png", "pdf" or "none". arrays: "npz", "csv", "fits" or "none".
    force: replaces files in the folder that are no results.
    threads: absent: all that the process may use. The result does not depend on it.
    progress: called with a line of text now and then, e.g. `print`.

    Ctrl-C ends the fit with the best so far (`result.interrupted`). Raises InputError and ComputationError.
    """
    arguments = locals()
    return _run("fit", **arguments)


def _takes_what_fit_takes(command):
    """Puts the arguments of `fit` in the place of **options: in help(), and in what is refused."""
    own = inspect.signature(command)
    names = {name: p for name, p in own.parameters.items() if p.kind is not p.VAR_KEYWORD}
    shared = [p for name, p in inspect.signature(fit).parameters.items() if name not in names]
    signature = own.replace(parameters=[*names.values(), *shared])

    @functools.wraps(command)
    def checked(*arguments, **options):
        signature.bind(*arguments, **options)
        return command(*arguments, **options)

    checked.__signature__ = signature
    return checked


@_takes_what_fit_takes
def check(study, **options) -> Result:
    """Says what the mean focus is and which model, terms, memory and time a study needs; fits nothing."""
    return _run("check", study, **options)


@_takes_what_fit_takes
def verify(study, *, coefficients=None, **options) -> Result:
    """Compares Harvey-Shack theory with random surfaces of terms, or with one surface, without a fit. Needs a
    roughness. coefficients: as for `trace`."""
    return _run("verify", study, coefficients=coefficients, **options)


@_takes_what_fit_takes
def trace(study, *, coefficients=None, **options) -> Result:
    """Computes the statistics of one surface: `coefficients` (a Surface, or the path of a coefficients.csv),
    or else the random surface of the study's seed."""
    return _run("trace", study, coefficients=coefficients, **options)


@_takes_what_fit_takes
def psd(study, **options) -> Result:
    """Estimates the PSD of the measurement that the study's roughness names, with a fitted model."""
    return _run("psd", study, **options)


@_takes_what_fit_takes
def solve(study, **options) -> Result:
    """Finds the roughness that meets the budgets of the study's block `solve`."""
    return _run("solve", study, **options)


@_takes_what_fit_takes
def chart(study, *, seconds=60, **options) -> Result:
    """Times models and fits on the study's scene for about `seconds`, each with its error."""
    return _run("chart", study, seconds=seconds, **options)


@_takes_what_fit_takes
def sweep(study, *, changes=None, output=None, **options):
    """Runs the cases of the study's block `vary` one after the other: an iterator of (values, Result).

    values: {"/json/pointer": value} of the case. Each case is a call of the command that `vary.run` names,
    whose other arguments it takes. output: each case writes to a folder of its own there, 0001 and so on. For
    thousands of cases the program's `aberfit sweep` is faster, and goes on where it was stopped.
    """
    given = [options.get(key) for key in ("profile", "map", "mask")]
    commands = {"check": check, "trace": trace, "fit": fit, "solve": solve}
    run, cases = _aberfit.sweep_cases(study_text(study, changes, *given))
    for k in range(len(cases)):
        values = {pointer: json.loads(value) for pointer, value in cases.at(k)}
        folder = None if output is None else os.path.join(path_text("output", output), f"{k + 1:04}")
        result = commands[run](study, changes={**(changes or {}), **values}, output=folder, **options)
        if result.interrupted:
            raise KeyboardInterrupt
        yield values, result


def schema(of="study") -> dict:
    """The JSON Schema of the "study" format, or of "results"."""
    if of not in ("study", "results"):
        refuse("of", repr(of), '"study" or "results"')
    return json.loads(_aberfit.results_schema() if of == "results" else _aberfit.study_schema())
