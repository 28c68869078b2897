#!/usr/bin/env bash
# Fuzzes the readers of texts and files. Builds the program with clang and runs each target for N seconds.
#   bash tests/fuzz/run.sh [--seconds N] [--release FOLDER] [TARGET...]
#   e.g. bash tests/fuzz/run.sh --seconds 300 study units
# Without TARGET it runs all. One input fails by a crash, a sanitizer's report, a leak, an exception that is
# no message for a user, more than 10 s or more than 2 GB. Such inputs are kept in build/fuzz/found/TARGET.
# Inputs that reach new code are kept in build/fuzz/corpus/TARGET for the next run.
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds=60
release=build/release
targets=()
while [ $# -gt 0 ]; do
  case $1 in
    --seconds) seconds=$2; shift 2 ;;
    --release) release=$2; shift 2 ;;
    -*) echo "usage: run.sh [--seconds N] [--release FOLDER] [TARGET...]" >&2; exit 2 ;;
    *) targets+=("$1"); shift ;;
  esac
done
bash fits/install_dependencies.sh --with-clang
[ -f "$release/build.ninja" ] || cmake --preset release -B "$release"
cmake --build "$release" --target aberfit
work=build/fuzz
cmake -S tests/fuzz -B "$work" -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DABERFIT_RELEASE="$(realpath "$release")" >/dev/null
cmake --build "$work"
fuzz=$work/fuzz
[ ${#targets[@]} -gt 0 ] || mapfile -t targets < <("$fuzz" --list | cut -d' ' -f1)

export ASAN_OPTIONS=detect_leaks=1 LSAN_OPTIONS=suppressions="$PWD/tests/leaks.txt":print_suppressions=0 UBSAN_OPTIONS=print_stacktrace=1
failed=()
for target in "${targets[@]}"; do
  longest=$("$fuzz" --list | awk -v target="$target" '$1 == target { print $2 }')
  [ -n "$longest" ] || { echo "no target $target; there are:" $("$fuzz" --list | cut -d' ' -f1) >&2; exit 2; }
  inputs=("$work/corpus/$target" "$work/seeds/$target")
  mkdir -p "${inputs[@]}" "$work/found/$target"
  "$fuzz" --target="$target" --write-seeds="$work/seeds/$target"
  [ -d "tests/fuzz/corpus/$target" ] && inputs+=("tests/fuzz/corpus/$target")
  log=$work/$target.log
  status=0
  "$fuzz" --target="$target" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -max_len="$longest" \
    -artifact_prefix="$work/found/$target/" -print_final_stats=1 "${inputs[@]}" >"$log" 2>&1 || status=$?
  awk -v target="$target" '
    /cov: /                       { match($0, /cov: [0-9]+/); coverage = substr($0, RSTART + 5, RLENGTH - 5) }
    /number_of_executed_units/    { executions = $2 }
    /slowest_unit_time_sec/       { slowest = $2 }
    /peak_rss_mb/                 { memory = $2 }
    END { printf "%-14s %9d executions, %5d edges, slowest %d s, %d MB\n", target, executions, coverage, slowest, memory }' "$log"
  if [ "$status" -ne 0 ]; then
    failed+=("$target")
    grep -m1 -A12 -E 'ERROR: |runtime error:|what\(\):|Test unit written' "$log" || tail -20 "$log"
    grep 'Test unit written' "$log" || true
  fi
done
[ ${#failed[@]} -eq 0 ] || { echo "failed: ${failed[*]}" >&2; exit 1; }
