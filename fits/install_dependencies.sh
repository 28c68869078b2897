#!/usr/bin/env bash
# Installs the Debian packages that aberfit is built from and tested with. Does nothing if all are installed.
#   --with-clang   also installs what fuzzing and clang-tidy need
set -euo pipefail

packages=(
  g++ cmake ninja-build
  libceres-dev libeigen3-dev nlohmann-json3-dev libfftw3-dev   # fixed choice of the project, with GoogleTest
  libboost-dev librandom123-dev libcli11-dev libfmt-dev libcfitsio-dev
  libhdf5-dev libzip-dev libpugixml-dev                        # .datx and .x3p of instruments
  gnuplot-nox fonts-dejavu-core                                # pictures
  libkainjow-mustache-dev                                      # report.html
  libopenmpi-dev openmpi-bin                                   # sweeps over several machines; optional
  libgtest-dev python3-jsonschema libbenchmark-dev             # tests and benchmarks
  pybind11-dev python3-dev python3-numpy python3-pytest        # the Python package and its tests
  dpkg-dev file pkg-config                                     # packages: cpack -G DEB
  clang-format                                                 # what CI checks
  ccache                                                       # the preset dev
)

if [ "${1:-}" = --with-clang ]; then
  # Debian 12 has clang 14 and packages its sanitizers separately; llvm names the functions in their reports.
  packages+=(clang clang-tidy libclang-rt-14-dev llvm)
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$status" = installed ] || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "aberfit needs these Debian packages, and neither root nor sudo is at hand: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
echo "installing: ${missing[*]}"
"${as_root[@]}" apt-get update -q
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}"
