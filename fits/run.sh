#!/usr/bin/env bash
# Runs a study on a fresh Debian machine: installs dependencies, builds the release, fits, judges and draws
# pictures.
#   bash fits/run.sh [STUDY.json]      default: the study of the README, fits/paper-mirror/study.json
set -euo pipefail
study=$(realpath "${1:-$(dirname "$0")/paper-mirror/study.json}")
cd "$(dirname "$0")/.."
bash fits/install_dependencies.sh
[ -f build/release/build.ninja ] || cmake --preset release
if [ ! -x build/release/aberfit ]; then
  echo "building aberfit: about three minutes on two cores, once"
fi
cmake --build build/release --target aberfit_program
name=$(basename "$(dirname "$study")")
status=0
build/release/aberfit fit "$study" -o "out/$name/fit" || status=$?
if [ -f "out/$name/fit/report.html" ]; then
  echo; echo "The report, to be opened in a browser: out/$name/fit/report.html"
fi
exit $status
