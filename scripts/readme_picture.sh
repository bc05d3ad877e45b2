#!/usr/bin/env bash
# Renders the picture at the top of README.md:
#   scripts/readme_picture.sh [PROGRAM]       default: build/release/skywave
# It shows the gallery through a lens and takes about two minutes on two threads. Photon maps find
# the caustics of the sun, which path tracing meets by chance, as bright dots. The picture is
# rendered three times as wide and high as it is shown, and blocks of 3 x 3 pixels are averaged as
# they are displayed, so a single bright sample cannot make a bright dot either. The script needs
# cjpeg (apt-get install libjpeg-turbo-progs) and Python 3.
set -euo pipefail
cd "$(dirname "$0")/.."
program=${1:-build/release/skywave}
out=docs/images/gallery.jpg
if ! command -v cjpeg >/dev/null; then
  echo "there is no cjpeg: apt-get install libjpeg-turbo-progs" >&2
  exit 1
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$program" render gallery --size 2304x1152 --spp 32 \
  --eye=-0.9,1.7,6.6 --target 0.36,0.74,0 --fov 25.5 --lens-radius 0.06 --focal-distance 5.95 \
  --integrator photon --guide --max-depth 8 --photons 500000 --caustic-photons 500000 \
  --tone filmic -o "$work/gallery.exr"

PYTHONPATH=scripts python3 -B - "$work" <<'PYTHON'
import pathlib
import sys
from sheet import read_png

FACTOR = 3
work = pathlib.Path(sys.argv[1])
width, height, rgb = read_png(work / "gallery.png")
small_width, small_height, stride = width // FACTOR, height // FACTOR, 3 * width
small = bytearray(3 * small_width * small_height)
for y in range(small_height):
    rows = [rgb[(FACTOR * y + k) * stride:(FACTOR * y + k + 1) * stride] for k in range(FACTOR)]
    for channel in range(3):
        columns = [row[channel + 3 * k::3 * FACTOR] for row in rows for k in range(FACTOR)]
        small[3 * y * small_width + channel:3 * (y + 1) * small_width:3] = bytes(
            round(sum(block) / len(block)) for block in zip(*columns))
(work / "gallery.ppm").write_bytes(b"P6 %d %d 255\n" % (small_width, small_height) + small)
PYTHON

cjpeg -quality 90 -optimize -progressive -outfile "$out" "$work/gallery.ppm"
echo "wrote $out, $(stat -c %s "$out") bytes"
