#!/usr/bin/env bash
# Installs the packages that a build on Debian 12, Debian 13 or Ubuntu 24.04 needs. Does nothing if
# they are installed.
#   scripts/setup.sh         the program
#   scripts/setup.sh python  also the Python package
#   scripts/setup.sh wheel   also wheels and the folder that run elsewhere
#   scripts/setup.sh test    also tests, benchmarks and the checks of .ci/run
set -euo pipefail
packages=(
  cmake ninja-build g++ git
  libembree-dev libtbb-dev libhwy-dev libglm-dev libopenexr-dev libpng-dev zlib1g-dev
  libdeflate-dev libxxhash-dev libtinyobjloader-dev libtinygltf-dev libfmt-dev libcli11-dev
  nlohmann-json3-dev libtomlplusplus-dev libstb-dev libdraco-dev libmeshoptimizer-dev libwebp-dev
)
python=(python3-dev python3-numpy pybind11-dev)
wheel=(python3-dev python3-venv file xz-utils)
test=(libgtest-dev libbenchmark-dev libnanoflann-dev python3 ccache valgrind groff-base pkg-config
      make munge slurm-client slurmctld slurmd "${python[@]}")
clang14=(clang-format-14 clang-tidy-14)  # others format and warn differently; Debian 13 has none
# shellcheck source=/dev/null
system=$(. /etc/os-release && echo "$ID ${VERSION_ID:-}")
case $system in
  "debian 12") packages+=(libjpeg62-turbo-dev); test+=("${clang14[@]}" mmdebstrap dpkg-dev file) ;;
  "debian 13") packages+=(libjpeg62-turbo-dev) ;;
  "ubuntu 24.04") packages+=(libjpeg-turbo8-dev); test+=("${clang14[@]}") ;;
  *)
    echo "scripts/setup.sh knows the packages of Debian 12 and 13 and Ubuntu 24.04, not of $system;" \
      "it takes the names of Debian 13" >&2
    packages+=(libjpeg-dev)
    ;;
esac
[[ ${1:-} != python ]] || packages+=("${python[@]}")
[[ ${1:-} != wheel ]] || packages+=("${wheel[@]}")
[[ ${1:-} != test ]] || packages+=("${test[@]}")
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
