#!/bin/bash
# Puts small faults into a copy of the sources, one after the other, and says which test catches each.
#   tests/mutants/run.sh [-d FOLDER] [NAME...]
# FOLDER keeps the copy and its build between runs (default: aberfit-mutants in TMPDIR). A NAME is that of a
# patch in this folder without `.patch`; default: all. Each patch states its fault and the tests that must
# catch it: "Caught by: PROGRAM...; FILTER". The exit code is 1 if a fault is not caught.
set -u
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
folder=${TMPDIR:-/tmp}/aberfit-mutants
if [ "${1:-}" = -d ]; then
  folder=$2
  shift 2
fi
names=("$@")
[ ${#names[@]} -gt 0 ] || mapfile -t names < <(cd "$here" && ls ./*.patch | sed 's|.*/||; s|[.]patch$||')

mkdir -p "$folder/source"
# We copy only files that git tracks, so that nothing built is copied. Only changed files get a new time. A
# source without its last fault is then newer than its object and is compiled again.
fresh=$(mktemp -d "$folder/fresh.XXXXXX") || exit 2
(cd "$root" && git ls-files -z | xargs -0 tar cf -) | tar xf - -C "$fresh" || exit 2
(cd "$fresh" && find . -type f -print0) | while IFS= read -r -d '' file; do
  cmp -s "$fresh/$file" "$folder/source/$file" && continue
  mkdir -p "$folder/source/$(dirname "$file")" && cp "$fresh/$file" "$folder/source/$file" || exit 2
done || exit 2
rm -rf "$fresh"
launcher=()
command -v ccache >/dev/null && launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
# Each source has its own object, so that a fault needs only one to be compiled.
cmake -S "$folder/source" -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DABERFIT_UNITY=OFF \
  "${launcher[@]}" >"$folder/configure.log" 2>&1 || { cat "$folder/configure.log"; exit 2; }

missed=0
for name in "${names[@]}"; do
  patch="$here/$name.patch"
  programs=$(sed -n 's/^Caught by: \([^;]*\);.*/\1/p' "$patch")
  filter=$(sed -n 's/^Caught by: [^;]*; *//p' "$patch")
  changed=$(sed -n 's|^+++ b/||p' "$patch")
  (cd "$folder/source" && git apply "$patch") || { echo "$name: does not apply"; missed=1; continue; }
  caught=""
  # shellcheck disable=SC2086
  if cmake --build "$folder/build" --target $programs >"$folder/build.log" 2>&1; then
    for program in $programs; do
      "$folder/build/tests/$program" --gtest_filter="$filter" >"$folder/$name.log" 2>&1
      found=$(sed -n 's/^\[  FAILED  \] \([A-Za-z]*[.][A-Za-z0-9/]*\).*/\1/p' "$folder/$name.log" | sort -u | head -3 | tr '\n' ' ')
      caught="$caught$found"
    done
    if [ -n "$caught" ]; then
      printf '%-32s caught by %s\n' "$name" "$caught"
    else
      printf '%-32s NOT CAUGHT by %s %s\n' "$name" "$programs" "$filter"
      missed=1
    fi
  else
    printf '%-32s does not compile: %s/build.log\n' "$name" "$folder"
    missed=1
  fi
  for file in $changed; do cp "$root/$file" "$folder/source/$file"; done
done
exit "$missed"
