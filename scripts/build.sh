#!/usr/bin/env bash
# Installs what is missing and builds a preset into build/:
#   scripts/build.sh                             the program alone, build/release/skywave
#   scripts/build.sh PRESET [-DNAME=VALUE...]    all of release (with tests and benchmarks), debug,
#                                                checks, asan, tsan or clang
# Programs and tests of the preset release share build/release, so neither is compiled twice.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-program}
needs=test
[[ $preset != program ]] || needs=
scripts/setup.sh $needs
cmake --preset "$preset" "${@:2}" >/dev/null
echo "building $preset with ${JOBS:-$(nproc)} jobs in $PWD/build" >&2
# Someone who looks on sees how far it is; a log has only what went wrong.
quiet=--quiet
[[ ! -t 1 ]] || quiet=
NINJA_STATUS="[%f/%t, %es] " \
  cmake --build --preset "$preset" -j"${JOBS:-$(nproc)}" -- $quiet
# Editors and clang-tidy look for the file here.
case $preset in
  program | release) ln -sf build/release/compile_commands.json compile_commands.json ;;
esac
