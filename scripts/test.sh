#!/usr/bin/env bash
# Sets up, builds and runs all tests; "asan" also runs them under the address and
# undefined-behaviour sanitizers, with the invariants of every wave checked.
set -euo pipefail
cd "$(dirname "$0")/.."
for preset in release "$@"; do
  scripts/build.sh "$preset"
  ctest --test-dir "build/$preset" -j2 --output-on-failure
done
