#!/usr/bin/env bash
# Builds the program and renders the built-in gallery to renders/gallery.exr and .png; with
# arguments, it runs `skywave render` with them.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/build.sh
mkdir -p renders
if [[ $# -eq 0 ]]; then
  # Merging finds the sun's caustics, which would be bright dots by path tracing.
  build/release/skywave render gallery --integrator vcm --guide --photons 1000000 \
    --photon-distance 0.05 --spp 32 --tone filmic -o renders/gallery.exr
else
  build/release/skywave render "$@"
fi
