#!/usr/bin/env python3
"""Joins the test files of a room into one to compile: in_one_unit.py UNIT.cpp FILE.cpp...

Headers and templates are most of what it costs to compile a test; in one unit they are read once. What a file defines
stands in a namespace named after it, below the one where the file has it, so that files may use the same names, and `#line`
keeps the places that compiler and failing tests print. A file with preprocessor lines of its own other than includes
cannot be wrapped and is not given here.
"""
import pathlib
import re
import sys


def with_its_place(include, path):
    """A header beside the test, by its whole path: the unit is in another folder."""
    name = re.match(r'#include "(.*)"', include)
    beside = path.parent / name.group(1) if name else None
    return f'#include "{beside.resolve()}"\n' if beside and beside.exists() else include


def in_its_namespace(body, name):
    """`namespace a::b {` ... `}  // namespace a::b` at the start of lines get the file's namespace below them."""
    body = re.sub(r"^namespace ([\w:]+) \{$", rf"}} namespace \1 {{ namespace {name} {{ using namespace ::{name};", body, flags=re.M)
    body = re.sub(r"^\}  // namespace [\w:]+$", rf"}} }} namespace {name} {{", body, flags=re.M)
    return f"namespace {name} {{\n{body}}}\n"


def main(unit, files):
    includes, bodies = {}, []
    for path in map(pathlib.Path, files):
        lines = path.read_text().splitlines(keepends=True)
        last = max(i for i, line in enumerate(lines) if line.startswith("#include"))
        for i, line in enumerate(lines[: last + 1]):
            if line.startswith("#include"):
                includes.setdefault(with_its_place(line, path), f'#line {i + 1} "{path}"\n')
        body = f'#line {last + 2} "{path}"\n' + "".join(lines[last + 1:])
        bodies.append(in_its_namespace(body, path.stem))
    pathlib.Path(unit).write_text("".join(where + include for include, where in includes.items()) + "".join(bodies))


main(sys.argv[1], sys.argv[2:])
