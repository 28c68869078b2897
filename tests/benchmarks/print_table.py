#!/usr/bin/env python3
"""One table from the JSON files of the benchmark programs: every row with its error and its time.

    print_table.py [--markdown] FILE.json...

Time: median over the repetitions, with half the distance of the quartiles in percent of it, and the smallest.
Ratio: time over that of the other way named beside it, both timed in turns in the same run; below 1 is faster.
Exit code 1 when a row's error is above what is allowed, or a row failed. Rows of methods that the operator refuses or does not
offer are named, not hidden."""
import argparse
import json
import platform
import re
import statistics
import sys

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


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--markdown", action="store_true", help="a compact table to paste")
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
    sys.exit(1 if failures else 0)


main()
