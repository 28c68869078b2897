#!/usr/bin/env bash
# Sets everything up on a fresh Debian machine and runs all tests: dependencies, release build, ctest.
#   bash tests/run.sh [CTEST ARGUMENTS]      e.g. bash tests/run.sh -L fit
set -euo pipefail
cd "$(dirname "$0")/.."
bash fits/install_dependencies.sh
[ -f build/release/build.ninja ] || cmake --preset release
cmake --build build/release
log=build/release/tests.log
status=0
ctest --test-dir build/release --output-on-failure --timeout 900 --parallel "$(nproc)" "$@" | tee "$log" || status=$?
# A test on files that are not here is skipped, which ctest takes for success: say how many looked at any.
told=$(grep -E ' Test +#[0-9]+: .*OnRealData\.' "$log" || true)
skipped=$(grep -c '\*\*\*Skipped' <<<"$told" || true)
all=$(grep -c . <<<"$told" || true)
echo "tests on real data (../shared/data): $((all - skipped)) ran, $skipped skipped"
exit $status
