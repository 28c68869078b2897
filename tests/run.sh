#!/usr/bin/env bash
# Sets everything up on a fresh Debian machine and runs all tests: dependencies, release build, ctest.
#   bash tests/run.sh [CTEST ARGUMENTS]      e.g. bash tests/run.sh -L fit
set -euo pipefail
cd "$(dirname "$0")/.."
bash fits/install_dependencies.sh
[ -f build/release/build.ninja ] || cmake --preset release
cmake --build build/release
exec ctest --test-dir build/release --output-on-failure --timeout 900 --parallel "$(nproc)" "$@"
