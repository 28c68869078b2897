#!/usr/bin/env bash
# Runs all tests on a fresh Debian machine: installs dependencies, builds the release and runs ctest.
#   bash tests/run.sh [CTEST ARGUMENTS]      e.g. bash tests/run.sh -L fit
set -euo pipefail
cd "$(dirname "$0")/.."
bash fits/install_dependencies.sh
[ -f build/release/build.ninja ] || cmake --preset release
cmake --build build/release
log=build/release/tests.log
status=0
ctest --test-dir build/release --output-on-failure --timeout 900 --parallel "$(nproc)" "$@" | tee "$log" || status=$?
# ctest counts a skipped test as passed, so we say how many tests on real data found their files.
told=$(grep -E ' Test +#[0-9]+: .*OnRealData\.' "$log" || true)
skipped=$(grep -c '\*\*\*Skipped' <<<"$told" || true)
all=$(grep -c . <<<"$told" || true)
echo "tests on real data (../shared/data): $((all - skipped)) ran, $skipped skipped"
exit $status
