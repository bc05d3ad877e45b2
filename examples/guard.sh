#!/usr/bin/env bash
# Holds every scene of a folder to its baseline (docs/regression.md of Skywave):
#   guard.sh FOLDER [OPTION of skywave bench ...]
# The scene of FOLDER/NAME.baseline.json is FOLDER/NAME.pbrt, .obj, .gltf, .glb or .ply, and its
# options, if any, are the words of FOLDER/NAME.options. SKYWAVE names the program. All scenes are
# gone through; the exit code is the first one that is not 0.
set -uo pipefail
folder=${1:?"guard.sh FOLDER [OPTION ...]"}
shift
status=0
for baseline in "$folder"/*.baseline.json; do
  [[ -e $baseline ]] || { echo "no baseline in $folder" >&2; exit 64; }
  name=${baseline%.baseline.json}
  scene=
  for file in "$name".{pbrt,obj,gltf,glb,ply}; do
    [[ -e $file ]] && scene=$file && break
  done
  [[ -n $scene ]] || { echo "$baseline: there is no scene of that name" >&2; exit 64; }
  options=()
  [[ ! -e $name.options ]] || read -r -d '' -a options < "$name.options" || true
  echo "== $scene"
  code=0
  "${SKYWAVE:-skywave}" bench "$scene" "${options[@]}" --baseline "$baseline" "$@" || code=$?
  [[ $status -ne 0 ]] || status=$code
done
exit "$status"
