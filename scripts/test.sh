#!/usr/bin/env bash
# Sets up, builds and runs all tests; with "asan" also under the address and undefined-behaviour
# sanitizers, with the invariants of every wave checked.
set -euo pipefail
cd "$(dirname "$0")/.."
for preset in release "$@"; do
  scripts/build.sh "$preset"
  exclude=()
  # Minutes of statistics, the suite's pictures, and malloc hooks that g++'s sanitizers lack: the
  # release build runs them; furnace and determinism tests take every stage through the sanitizers.
  [[ $preset == release ]] || exclude=(-E '^(oracle_test|export_render_test|allocation_test|bench_cli_test|counter_gate)$')
  ctest --test-dir "build/$preset" -j2 --output-on-failure "${exclude[@]}"
done
