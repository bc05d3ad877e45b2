#!/usr/bin/env bash
# Sets up, builds and renders a built-in scene to renders/SCENE.exr and .png. Arguments go to
# `skywave render`; without any the gallery is rendered.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/build.sh
mkdir -p renders
if [[ $# -eq 0 ]]; then
  build/release/skywave render gallery -o renders/gallery.exr
else
  build/release/skywave render "$@"
fi
