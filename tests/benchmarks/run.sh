#!/usr/bin/env bash
# Builds and runs the benchmarks and prints one table; every row has its error and its time.
#   bash tests/benchmarks/run.sh                    all of them, 5 repetitions: about five minutes
#   bash tests/benchmarks/run.sh focus fit          some of them
#   bash tests/benchmarks/run.sh --smoke            every row once, smaller cases: checks only the errors
#   bash tests/benchmarks/run.sh --markdown         prints a compact table in Markdown
#   bash tests/benchmarks/run.sh --page             rewrites README.md beside this script
#   bash tests/benchmarks/run.sh --repetitions 9    default 5; medians and quartiles are over these
# The results stay in build/release/tests/benchmarks/results/*.json; `print_table.py FILES` prints them again.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
cd "$here/../.."

subjects=() options=() table=() repetitions=5 page=
while [ $# -gt 0 ]; do
  case $1 in
    --smoke) options+=(--smoke) repetitions=1 ;;
    --markdown) table+=(--markdown) ;;
    --page) page=$here/README.md ;;
    --repetitions) repetitions=$2; shift ;;
    -*) echo "unknown option $1" >&2; exit 2 ;;
    *) subjects+=("$1") ;;
  esac
  shift
done
if [ -n "$page" ]; then
  if [ ${#subjects[@]} -gt 0 ] || [ ${#options[@]} -gt 0 ]; then
    echo "--page needs all subjects at full size" >&2
    exit 2
  fi
  table+=(--page "$page")
fi
if [ ${#subjects[@]} -eq 0 ]; then
  subjects=(operator trace focus evaluation harvey_shack waves fit study growth)
fi

bash fits/install_dependencies.sh >&2
[ -f build/release/build.ninja ] || cmake --preset release >&2
cmake --build build/release --target "${subjects[@]/%/_benchmark}" >&2

programs=build/release/tests/benchmarks results=build/release/tests/benchmarks/results
mkdir -p "$results"
failed=()
files=()
for subject in "${subjects[@]}"; do
  echo "running $subject" >&2
  rm -f "$results/$subject.json"
  # A repetition of a short case lasts 0.1 s; a repetition of a long case is a single call.
  "$programs/${subject}_benchmark" ${options[@]+"${options[@]}"} --benchmark_min_time=0.1 \
    --benchmark_repetitions="$repetitions" \
    --benchmark_out="$results/$subject.json" --benchmark_out_format=json \
    > "$results/$subject.log" 2>&1 || failed+=("$subject")
  files+=("$results/$subject.json")
done
status=0
python3 "$here/print_table.py" ${table[@]+"${table[@]}"} "${files[@]}" || status=1
for subject in ${failed[@]+"${failed[@]}"}; do
  grep '^FAILED' "$results/$subject.log" >&2 || tail -5 "$results/$subject.log" >&2
  status=1
done
exit $status
