#!/usr/bin/env python3
"""Packs the Python package of a build folder as a wheel: make_wheel.py PACKAGE_FOLDER VERSION OUTPUT_FOLDER.

The wheel is for this Python and this kind of machine. It needs the shared libraries (Ceres, FFTW and so on)
that it was built with."""

import base64
import hashlib
import pathlib
import sys
import sysconfig
import zipfile

EPOCH = (2020, 1, 1, 0, 0, 0)  # the same files make the same wheel


def main(package, version, output):
    package, output = pathlib.Path(package), pathlib.Path(output)
    abi = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{abi}-{abi}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
    info = f"aberfit-{version}.dist-info"
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    files = {
        f"aberfit/{f.name}": f.read_bytes()
        for f in sorted(package.iterdir())
        if f.suffix in (".py", ".typed") or f.name.endswith(suffix)
    }
    if f"aberfit/_aberfit{suffix}" not in files:
        raise SystemExit(f"{package} has no module _aberfit{suffix}; build the target aberfit_python first")
    files[f"{info}/METADATA"] = (
        f"Metadata-Version: 2.1\nName: aberfit\nVersion: {version}\n"
        "Summary: Equivalent aberration terms of rough mirrors\n"
        "Requires-Python: >=3.9\nRequires-Dist: numpy\n"
    ).encode()
    files[f"{info}/WHEEL"] = (
        f"Wheel-Version: 1.0\nGenerator: aberfit\nRoot-Is-Purelib: false\nTag: {tag}\n"
    ).encode()
    record = ""
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record += f"{name},sha256={digest},{len(content)}\n"
    files[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()
    path = output / f"aberfit-{version}-{tag}.whl"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, EPOCH)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            wheel.writestr(entry, content)
    print(path)


if __name__ == "__main__":
    main(*sys.argv[1:])
