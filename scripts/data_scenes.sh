#!/usr/bin/env bash
# Writes scene files that put the models of a data folder on a plane, ready for --env:
#   scripts/data_scenes.sh DATA_FOLDER OUT_FOLDER
# DATA_FOLDER holds models/killeroo.pbrt and models/bunny.ply. The models are included, not copied.
set -euo pipefail
if [[ $# -ne 2 || ! -d $1/models ]]; then
  echo "usage: scripts/data_scenes.sh DATA_FOLDER OUT_FOLDER  (DATA_FOLDER/models must exist)" >&2
  exit 64
fi
data=$(cd "$1" && pwd)
mkdir -p "$2"

# The pbrt world is left-handed; killeroo stands along z on the plane z = -140.
cat > "$2/killeroo.pbrt" <<EOF
LookAt 400 20 30  0 63 -110  0 0 1
Rotate -5 0 0 1
Camera "perspective" "float fov" [39]
Film "image" "integer xresolution" [640] "integer yresolution" [480]
Sampler "sobol" "integer pixelsamples" [64]
Integrator "path" "integer maxdepth" [5]
WorldBegin
AttributeBegin
  Material "matte" "rgb Kd" [0.5 0.5 0.5]
  Translate 0 0 -140
  Shape "trianglemesh" "point P" [-1000 -1000 0  1000 -1000 0  1000 1000 0  -1000 1000 0]
    "integer indices" [0 1 2 2 3 0]
AttributeEnd
AttributeBegin
  Material "matte" "rgb Kd" [0.4 0.2 0.2]
  Scale 0.5 0.5 0.5
  Rotate -60 0 0 1
  Translate 100 200 -140
  Include "$data/models/killeroo.pbrt"
AttributeEnd
AttributeBegin
  Material "matte" "rgb Kd" [0.4 0.35 0.3]
  Scale 0.5 0.5 0.5
  Translate 100 0 -140
  Include "$data/models/killeroo.pbrt"
AttributeEnd
WorldEnd
EOF

cat > "$2/bunny.pbrt" <<EOF
LookAt -0.03 0.14 0.32  -0.016 0.072 0  0 1 0
Camera "perspective" "float fov" [38]
Film "image" "integer xresolution" [640] "integer yresolution" [480]
Sampler "sobol" "integer pixelsamples" [64]
Integrator "path" "integer maxdepth" [5]
WorldBegin
AttributeBegin
  Material "matte" "rgb Kd" [0.5 0.5 0.5]
  Shape "trianglemesh" "point P" [-2 0 -2  2 0 -2  2 0 2  -2 0 2]
    "integer indices" [0 1 2 2 3 0]
AttributeEnd
Material "matte" "rgb Kd" [0.6 0.5 0.4]
Shape "plymesh" "string filename" ["$data/models/bunny.ply"]
WorldEnd
EOF
echo "wrote $2/killeroo.pbrt and $2/bunny.pbrt"
