#!/usr/bin/env bash
# Makes wheels of the Python package that hold all libraries they need, in build/portable/wheels:
#   scripts/build_wheels.sh
# One is for Debian's own Python, made with pybind11 as everywhere else. Root makes another for the
# stable ABI, which every Python from 3.12 on takes: the same module by nanobind (python/binding.h).
# Its headers are those of Debian 13, from a root. Both are compiled here, so that neither asks for a
# newer glibc than this system has: on Debian 12 they run on every Linux with glibc 2.36. pip reads
# their names and refuses to install them elsewhere.
set -euo pipefail
cd "$(dirname "$0")/.."
# shellcheck source=scripts/bundle.sh
. scripts/bundle.sh
# shellcheck source=scripts/debian_root.sh
. scripts/debian_root.sh
scripts/setup.sh wheel
make_tools
export PATH=$tools/bin:$PATH CCACHE_BASEDIR=${CCACHE_BASEDIR:-$PWD}
folder=$PWD/build/portable
start=$SECONDS
rm -rf "$folder"/{plain,changed,wheels}
mkdir -p "$folder"/{plain,changed,wheels}

pip wheel . --quiet --disable-pip-version-check --no-deps --no-build-isolation \
  --wheel-dir "$folder/plain"
wheel unpack "$folder"/plain/skywave-*.whl --dest "$folder/changed" >/dev/null
content=$(echo "$folder"/changed/skywave-*)
licences=$(echo "$content"/*.dist-info)/licenses
mapfile -t libraries < <(libraries_of "$content/skywave/"{_core.*.so,bin/skywave} |
                           grep -v /libskywave)
add_licences "$licences" "${libraries[@]}"
packages=$(echo "$tools"/lib/python3*/site-packages)
cp "$packages"/pybind11-*.dist-info/licenses/LICENSE "$licences/pybind11.txt"
wheel pack "$content" --dest-dir "$folder/changed" >/dev/null

# The module for the stable ABI: the same source, other headers.
version=3.13
if (make_root trixie build/roots/trixie); then
  headers=$folder/python$version/usr/include
  if [[ ! -f $headers/python$version/Python.h ]]; then
    in_root build/roots/trixie apt-get update -qq
    in_root build/roots/trixie env --chdir=/tmp apt-get download -qq "libpython$version-dev"
    dpkg -x build/roots/trixie/tmp/libpython"$version"-dev_*.deb "$folder/python$version"
    rm build/roots/trixie/tmp/*.deb
  fi
  rm "$content"/skywave/_core.*.so "$licences/pybind11.txt"
  g++ -std=c++20 -O1 -fPIC -shared -s -DNDEBUG -fvisibility=hidden -fvisibility-inlines-hidden \
    -fno-strict-aliasing -DPy_LIMITED_API=0x030C0000 -I "$headers" -I "$headers/python$version" \
    -I "$packages/nanobind/include" -I "$packages/nanobind/ext/robin_map/include" \
    -I build/wheel/include/public python/module.cc "$packages/nanobind/src/nb_combined.cpp" \
    "$content/skywave/libskywave.so.0" -Wl,-rpath,"\$ORIGIN" -o "$content/skywave/_core.abi3.so"
  cp "$packages"/nanobind-*.dist-info/licenses/LICENSE "$licences/nanobind.txt"
  sed '/\*\//q' "$packages/nanobind/ext/robin_map/include/tsl/robin_map.h" > "$licences/robin_map.txt"
  sed -i -E "s/^Tag: .*/Tag: cp312-abi3-linux_x86_64/" "$content"/*.dist-info/WHEEL
  wheel pack "$content" --dest-dir "$folder/changed" >/dev/null
else
  echo "not built: the wheel for Python 3.12 and newer, whose headers come from a root of Debian 13"
fi

glibc=$(getconf GNU_LIBC_VERSION)
platform=manylinux_${glibc#glibc }_x86_64
for wheel in "$folder"/changed/*.whl; do
  auditwheel repair --strip --plat "${platform/./_}" --wheel-dir "$folder/wheels" "$wheel" \
    > "$folder/auditwheel.log" 2>&1 || { cat "$folder/auditwheel.log" >&2; exit 1; }
done
for wheel in "$folder"/wheels/*.whl; do
  size=$(stat -c %s "$wheel")
  echo "$(basename "$wheel"): $(awk "BEGIN { printf \"%.1f\", $size / 1e6 }") MB"
  [[ $size -lt 40000000 ]] || { echo "a wheel of more than 40 MB" >&2; exit 1; }
done
# That no symbol is newer than the stable ABI that a name promises.
for wheel in "$folder"/wheels/*-abi3-*.whl; do
  [[ ! -f $wheel ]] || abi3audit --strict "$wheel"
done
echo "made in $((SECONDS - start)) s"
