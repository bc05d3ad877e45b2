#!/usr/bin/env bash
# Builds a preset (default: release) into build/PRESET; the program is build/release/skywave.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
scripts/setup.sh
cmake --preset "$preset" >/dev/null
cmake --build "build/$preset" -j"${JOBS:-2}" -- --quiet
