#!/usr/bin/env bash
# Tests scenes from the meshes of other Python packages, and mattes by another decoder, with the real
# packages, which it installs from PyPI into a virtual environment of its own (1.5 GB); PYTHON may name another Python. With bpy in it
# (pip install bpy) Blender takes part in the orders of imports.
#   scripts/test_python_packages.sh            after scripts/build.sh release
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh wheel
environment=$PWD/build/python_packages
[[ -x $environment/bin/python ]] || "${PYTHON:-/usr/bin/python3}" -m venv "$environment"
if ! "$environment/bin/pip" install --quiet --disable-pip-version-check --timeout 30 --retries 1 \
  trimesh scipy pillow pyrender pyvista open3d cadquery h5py embreex OpenEXR cryptomatte-api; then
  echo "skipped: packages of PyPI cannot be installed"
  exit 77
fi
export PYTHONPATH=$PWD/build/release/python SKYWAVE_PROGRAM=$PWD/build/release/skywave
for test in packages imports mattes docs; do
  "$environment/bin/python" -B -W ignore "tests/python/${test}_test.py"
done
