#!/usr/bin/env bash
# Tests scenes from the meshes of other Python packages, and mattes by another decoder, with the real
# packages, which it installs from PyPI into a virtual environment of its own (2.4 GB); PYTHON may
# name another Python. The orders of imports are tried with the wheel, where scripts/build_wheels.sh
# has made one, because its libraries are those that could meet the libraries of the others.
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
# Blender: PyPI has it for some Pythons.
"$environment/bin/pip" install --quiet --disable-pip-version-check --timeout 30 --retries 1 bpy ||
  echo "without bpy, which PyPI does not have for this Python"
export PYTHONPATH=$PWD/build/release/python SKYWAVE_PROGRAM=$PWD/build/release/skywave
for test in packages mattes docs; do
  "$environment/bin/python" -B -W ignore "tests/python/${test}_test.py"
done
if compgen -G "build/portable/wheels/*.whl" >/dev/null; then
  "$environment/bin/pip" install --quiet --disable-pip-version-check --force-reinstall --no-deps \
    --no-index --find-links build/portable/wheels skywave
  unset PYTHONPATH
fi
"$environment/bin/python" -B -W ignore tests/python/imports_test.py
