#!/usr/bin/env bash
# Builds the program and renders the built-in gallery to renders/gallery.exr and .png; with
# arguments, it runs `skywave render` with them. A first build has the kernels for this processor
# alone, which compile in half of the time; `scripts/build.sh release` adds those for others.
set -euo pipefail
cd "$(dirname "$0")/.."
options=()
[[ -e build/release/CMakeCache.txt ]] || options=(-DSKYWAVE_TARGETS=here)
scripts/build.sh program "${options[@]}"
mkdir -p renders
if [[ $# -eq 0 ]]; then
  # Paths find the sun's caustics too seldom: the limit removes the bright dots that they would be.
  build/release/skywave render gallery --spp 128 --clamp-indirect 8 --denoise --tone filmic \
    -o renders/gallery.exr
else
  build/release/skywave render "$@"
fi
