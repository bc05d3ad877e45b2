#!/usr/bin/env bash
# Builds the preset release and runs all of its tests, then those of other presets:
#   scripts/test.sh [PRESET...] [-DNAME=VALUE...]
# The preset asan runs them under the address and undefined-behaviour sanitizers, with the
# invariants of every wave checked. Options of CMake hold for all presets.
set -euo pipefail
cd "$(dirname "$0")/.."
presets=(release)
options=()
for argument in "$@"; do
  case $argument in
    -D*) options+=("$argument") ;;
    *) presets+=("$argument") ;;
  esac
done
for preset in "${presets[@]}"; do
  scripts/build.sh "$preset" "${options[@]}"
  ctest --test-dir "build/$preset" -j"${JOBS:-$(nproc)}" --output-on-failure
done
