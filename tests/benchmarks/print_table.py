#!/usr/bin/env python3
"""One table from the JSON files of the benchmark programs: every row with its error and its time.

    print_table.py [--markdown] [--page README.md] FILE.json...

Time: median over the repetitions, with half the distance of the quartiles in percent of it, and the
smallest.
Ratio: time over that of the other way named beside it, both timed in turns in the same run; below 1 is faster.
The page has the rows of PAGE_ROWS and the sentences below, stamped with processor, date and commit.
Exit code 1 when a row's error is above what is allowed, or a row failed; then no page is written. Rows of
methods that the operator refuses or does not offer are named, not hidden."""
import argparse
import json
import os
import platform
import re
import statistics
import subprocess
import sys
import textwrap

PREFIXES = [(1e9, "G"), (1e6, "M"), (1e3, "k"), (1, "")]
TO_SECONDS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}


def in_seconds(seconds):
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def in_prefixes(value, unit):
    for size, prefix in PREFIXES:
        if value >= size:
            return f"{value / size:.3g} {prefix}{unit}/s"
    return f"{value:.3g} {unit}/s"


def quartile_spread(values):
    """Half the distance between the quartiles over the median."""
    if len(values) < 2:
        return None
    low, middle, high = statistics.quantiles(values, n=4, method="inclusive")
    return (high - low) / 2 / middle


def rows_of(document):
    """Repetitions of a row put together, in the order of the first."""
    rows = {}
    for entry in document["benchmarks"]:
        if entry.get("run_type", "iteration") != "iteration":
            continue
        name = re.sub(r"(/(manual_time|real_time|repeats:\d+|iterations:\d+|min_time:[\d.]+))+$", "", entry["name"])
        row = rows.setdefault(name, {"name": name, "seconds": [], "counters": {}, "trouble": ""})
        if entry.get("error_occurred"):
            row["trouble"] = entry.get("error_message", "failed")
            continue
        row["seconds"].append(entry["real_time"] * TO_SECONDS[entry.get("time_unit", "ns")])
        for key, value in entry.items():
            if key in ("error", "allowed") or re.match(r"(rate|ratio):", key) or key in ("peak_MB", "allowed_MB", "predicted"):
                row["counters"].setdefault(key, []).append(value)
    return list(rows.values())


def cells(row):
    case, _, setting = row["name"].partition("/")
    if row["trouble"]:
        return [case, setting, row["trouble"], "", "", "", "", "", ""]
    counters = row["counters"]
    text = lambda key: f"{max(counters[key]):.3g}" if key in counters else ""
    middle = statistics.median(row["seconds"])
    spread = quartile_spread(row["seconds"])
    rate = ratio = ""
    for key, values in counters.items():
        if key.startswith("rate:") and key[5:] not in ("fits", "studies", "targets"):
            rate = in_prefixes(statistics.median(values), key[5:])
            if key == "rate:rays":
                rate += f", {1e9 / statistics.median(values):.3g} ns each"
        if key.startswith("ratio:"):
            ratio = f"{statistics.median(values):.3g} x {key[6:]}"
        if key == "predicted":
            ratio = f"{middle / statistics.median(values):.2g} x predicted"
        if key == "peak_MB":
            rate = f"{max(values):.0f} MB"
    return [case, setting, text("error"), text("allowed"), in_seconds(middle),
            "" if spread is None else f"{100 * spread:.0f} %", in_seconds(min(row["seconds"])), rate, ratio]


def problems(row):
    """Sentences for what is wrong with a row, and whether that is a failure."""
    if row["trouble"]:
        soft = row["trouble"].startswith("refused")
        return [(f"{row['name']}: {row['trouble']}", not soft)]
    counters = row["counters"]
    if "error" not in counters or "allowed" not in counters:
        return [(f"{row['name']}: no error stated", True)]
    found = [(f"{row['name']}: error {error:.3g}, allowed {allowed:.3g}", True)
             for error, allowed in zip(map(float, counters["error"]), map(float, counters["allowed"]))
             if not error <= allowed]
    if "peak_MB" in counters and not max(counters["peak_MB"]) <= counters["allowed_MB"][0]:
        found.append((f"{row['name']}: {max(counters['peak_MB']):.0f} MB, "
                      f"allowed {counters['allowed_MB'][0]:.0f} MB", True))
    return found


def clearance(rows):
    """The row whose error comes nearest to what is allowed, as a sentence."""
    shares = [(max(e / a for e, a in zip(row["counters"]["error"], row["counters"]["allowed"])), row["name"])
              for row in rows if {"error", "allowed"} <= row["counters"].keys()]
    if not shares:
        return ""
    worst, name = max(shares)
    return f"worst clearance (error over allowed) {worst:.2g}: {name}"


def processor():
    try:
        with open("/proc/cpuinfo") as file:
            for line in file:
                if line.startswith("model name"):
                    return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def machine_line(contexts):
    own = next((c for c in contexts if "instruction_set" in c), {})
    loads = [c["load_avg"][0] for c in contexts if c.get("load_avg")]
    parts = [processor(), own.get("instruction_set", ""), f"{own.get('threads', '?')} threads"]
    if loads:
        parts.append(f"load {max(loads):.1f}")
    return ", ".join(part for part in parts if part)


TITLES = ["case", "setting", "error", "allowed", "time", "+-", "fastest", "rate", "ratio"]
RIGHT = {2, 3, 4, 5, 6, 7}


def aligned(table):
    widths = [max(len(line[k]) for line in table if not (k == 2 and line[3] == "" and line[4] == ""))
              for k in range(len(TITLES))]
    out = []
    last_case = None
    for number, line in enumerate(table):
        shown = list(line)
        if number > 0 and line[0] == last_case:
            shown[0] = ""
        last_case = line[0]
        if line[4] == "":  # trouble: one sentence over the columns of numbers
            out.append(f"{shown[0]:<{widths[0]}}  {shown[1]:<{widths[1]}}  {shown[2]}")
            continue
        out.append("  ".join(f"{cell:>{width}}" if k in RIGHT else f"{cell:<{width}}"
                             for k, (cell, width) in enumerate(zip(shown, widths))).rstrip())
    return out


def markdown(table):
    out = ["| case | error | time | rate | ratio |", "|---|---|---|---|---|"]
    for case, setting, error, allowed, time, spread, _, rate, ratio in table[1:]:
        if time:
            out.append(f"| {case}: {setting} | {error} | {time} | {rate} | {ratio} |")
    return out


# What the page shows of all rows, in this order: case, and a pattern of the settings.
PAGE_ROWS = [
    ("Zernike sum and gradient", r"n = 20, .*|n = 80, .*polar"),
    ("Fourier sum and gradient", r"56 cycles.*"),
    ("Parabola with 231 Zernikes to focus", r".*2 threads"),
    ("Values and Jacobian", r"66 .*"),
    ("Fit", r".*"),
    ("Mean spot", r"EE.*k-correlation.*"),
    ("Diffraction", r".*\d+ statistics.*"),
    ("Study from the command line", r".*"),
]
LONGEST_LINE = 110

PAGE_HEAD = """# Accuracy and speed

Every row has an error beside its time. The error is measured in the same run, against a second way to the
same numbers. It is relative to the largest of them; of a fit it is the largest mismatch, of rays it is in
units of what is allowed. The run fails beyond *allowed*. `bash tests/benchmarks/run.sh --page` measures all
rows and writes this page.
"""

# Largest errors that these tests have seen; each asserts a bound of its own.
PAGE_ACCURACY = """## Accuracy that tests hold

| what | reference | largest error |
|---|---|---|
| Zernikes, [n = 100 / 300](../terms/zernike_test.cpp) | 200-digit sums | 2.5e-13 / 2.2e-12 of the mode |
| [modal covariance](../terms/zernike_covariance_test.cpp) | closed form | 1e-15 |
| [geometric Harvey-Shack](../theory/geometric_harvey_shack_test.cpp) | mpmath | 5e-12 |
| [generalised Harvey-Shack](../theory/generalised_harvey_shack_test.cpp) | converged quadrature | 1e-11 |
| the same, [10 scenes](../theory/ghs_ensemble_test.cpp) | means of 200 PSFs | 2.6 standard errors |
| [gradients by waves](../waves/diffraction_gradient_test.cpp) | dual numbers, direct sums | 1e-8 |
| [23 fits, g 0.07 to 7](../sweep/generated_scenes_test.cpp) | a second wave code | 0.84 of the 1 % margin |
| [90 % intervals](../method/ray_interval_test.cpp) | a hundred times the rays | cover 90.5 % |
| [95 % intervals of PSD models](../spectrum/psd_synthetic_test.cpp) | the truth | cover 94.9 % |
| [terms of a map](../fits/measured_surfaces_test.cpp) | what was put in | 0.12 nm, EE90 0.002 % |
"""

PAGE_CHART = """## On your own scene

`aberfit chart STUDY` compares models, whole fits and cuts of the band:

![Error against time of rays and waves](../../fits/paper-physical/chart_models.png)

*`aberfit chart fits/paper-physical/study.json`, one of its pictures: error of one surface by waves against
the time of computing it. No number of rays meets the tolerance here. Today's setting is ringed; the red
diamond is the cheapest within tolerance.*
"""


def commit():
    """Of the sources beside this script; empty without git."""
    try:
        folder = os.path.dirname(os.path.abspath(__file__))
        told = subprocess.run(["git", "-C", folder, "describe", "--always", "--dirty", "--abbrev=12"],
                              capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return ""
    return told.stdout.strip()


def stamp(rows, contexts):
    """A sentence: on what, when and how the rows were measured."""
    dates = [c["date"][:10] for c in contexts if c.get("date")]
    times = statistics.mode(len(row["seconds"]) for row in rows)
    text = f"Measured on {machine_line(contexts)}"
    text += f", on {max(dates)}" if dates else ""
    text += f", at commit {commit()}" if commit() else ""
    text += f"; each time is the median of {times}."
    return textwrap.fill(text, LONGEST_LINE, break_on_hyphens=False) + "\n"


def page_table(table):
    """Rows of cells() that the page shows, under their cases; the rate without the time of one."""
    out = ["| case | error | allowed | time | rate |", "|---|---:|---:|---:|---:|"]
    for case, pattern in PAGE_ROWS:
        chosen = [line for line in table if line[0] == case and line[4] and re.fullmatch(pattern, line[1])]
        if chosen:
            out.append(f"| **{case}** | | | | |")
        for _, setting, error, allowed, time, _, _, rate, _ in chosen:
            out.append(f"| {setting} | {error} | {allowed} | {time} | {rate.split(', ')[0]} |")
    long = [line for line in out if len(line) > LONGEST_LINE]
    if long:
        sys.exit("too long for the page: " + long[0])
    return "\n".join(out) + "\n"


def page(table, measured):
    return "\n".join([PAGE_HEAD, measured, page_table(table), PAGE_ACCURACY, PAGE_CHART])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--markdown", action="store_true", help="a compact table to paste")
    parser.add_argument("--page", metavar="FILE", help="write the page there, too")
    parser.add_argument("files", nargs="+")
    arguments = parser.parse_args()
    rows, contexts = [], []
    for path in arguments.files:
        with open(path) as file:
            document = json.load(file)
        contexts.append(document.get("context", {}))
        rows += rows_of(document)
    if not rows:
        sys.exit("no rows in " + ", ".join(arguments.files))
    table = [TITLES] + [cells(row) for row in rows]
    print("\n".join(markdown(table) if arguments.markdown else aligned(table)))
    print()
    print(machine_line(contexts))
    print(clearance(rows))
    found = list(dict.fromkeys(problem for row in rows for problem in problems(row)))
    left_out = [text for text, failure in found if not failure]
    failures = [text for text, failure in found if failure]
    if left_out:
        print(f"{len(left_out)} rows without a time: the operator refused or did not offer the method")
    for text in failures:
        print("FAILED " + text)
    if failures:
        sys.exit(1)
    if arguments.page:
        text = page(table[1:], stamp(rows, contexts))
        with open(arguments.page, "w") as file:
            file.write(text)


if __name__ == "__main__":
    main()
