#!/usr/bin/env bash
# Runs clang-tidy on the library and the program with the checks of .clang-tidy; fails if it finds anything.
#   bash tests/tidy.sh [ROOM...]      e.g. bash tests/tidy.sh measured study
# It reads a room as one unit, as it is compiled, so that headers are read once. Each room takes minutes.
set -euo pipefail
cd "$(dirname "$0")/.."
bash fits/install_dependencies.sh --with-clang
# clang-tidy needs the compile commands of clang, because it cannot read precompiled headers of GCC.
cmake -S . -B build/tidy -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DABERFIT_TESTS=OFF >/dev/null
mapfile -t units < <(grep -oP '"file": "\K[^"]+' build/tidy/compile_commands.json)
status=0
for unit in "${units[@]}"; do
  if [ $# -gt 0 ]; then
    wanted=false
    for room in "$@"; do
      [[ $unit == */unity_src/${room}_cxx.cxx || $unit == */src/$room/* ]] && wanted=true
    done
    $wanted || continue
  fi
  echo "$unit"
  clang-tidy -p build/tidy --quiet --config-file=.clang-tidy "$unit" || status=1
done
exit $status
