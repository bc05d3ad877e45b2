#!/usr/bin/env bash
# Installs the packages for building from Debian 12. Does nothing if they are installed.
#   scripts/setup.sh         the program
#   scripts/setup.sh test    also tests, benchmarks and the checks of .ci/run
set -euo pipefail
packages=(
  cmake ninja-build g++ git
  libembree-dev libtbb-dev libhwy-dev libglm-dev libopenexr-dev libpng-dev libjpeg62-turbo-dev zlib1g-dev
  libxxhash-dev libtinyobjloader-dev libtinygltf-dev libfmt-dev libcli11-dev nlohmann-json3-dev
)
if [[ ${1:-} == test ]]; then
  packages+=(
    libgtest-dev libbenchmark-dev libnanoflann-dev python3 ccache
    python3-dev python3-numpy python3-pybind11 pybind11-dev
    valgrind clang-format-14 clang-tidy-14
  )
fi
missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${Status}' "$package" 2>/dev/null || true)
  [[ $status == "install ok installed" ]] || missing+=("$package")
done
[[ ${#missing[@]} -eq 0 ]] && exit 0

echo "installing: ${missing[*]}"
as_root=()
if [[ $(id -u) -ne 0 ]]; then
  command -v sudo >/dev/null || { echo "run scripts/setup.sh as root, or install sudo" >&2; exit 1; }
  as_root=(sudo)
fi
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
  "${missing[@]}" >/dev/null
