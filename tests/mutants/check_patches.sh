#!/bin/bash
# Checks that every patch of this folder still applies to the sources. Prints those that do not.
set -u
here=$(cd "$(dirname "$0")" && pwd)
cd "$here/../.." || exit 2
status=0
count=0
for patch in "$here"/*.patch; do
  name=$(basename "$patch" .patch)
  count=$((count + 1))
  if ! grep -q '^Fault: ' "$patch" || ! grep -q '^Caught by: ' "$patch"; then
    echo "$name: says neither its fault nor what catches it" && status=1
  fi
  if ! git apply --check "$patch" 2>/dev/null; then
    echo "$name: no longer applies" && status=1
  fi
done
[ "$count" -gt 0 ] || { echo "no patches in $here"; status=1; }
[ "$status" = 0 ] && echo "$count patches apply"
exit "$status"
