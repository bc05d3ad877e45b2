#!/usr/bin/env bash
# Makes wheels of the Python package that hold all libraries they need, in build/portable/wheels:
#   scripts/build_wheels.sh
# One is for Debian's own Python; by root there is another for the Python of Debian 13, whose headers
# come from a root of that release. Both are compiled here, so that neither asks for a newer glibc
# than this system has: on Debian 12 they run on every Linux with glibc 2.36. pip reads their names
# and refuses to install them elsewhere.
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
cp "$tools"/lib/python3*/site-packages/pybind11-*.dist-info/licenses/LICENSE "$licences/pybind11.txt"
wheel pack "$content" --dest-dir "$folder/changed" >/dev/null

# The module for another Python than Debian's own: the same source, other headers.
version=3.13
if (make_root trixie build/roots/trixie); then
  headers=$folder/python$version/usr/include
  if [[ ! -f $headers/python$version/Python.h ]]; then
    in_root build/roots/trixie apt-get update -qq
    in_root build/roots/trixie env --chdir=/tmp apt-get download -qq "libpython$version-dev"
    dpkg -x build/roots/trixie/tmp/libpython"$version"-dev_*.deb "$folder/python$version"
    rm build/roots/trixie/tmp/*.deb
  fi
  short=${version/./}
  rm "$content"/skywave/_core.*.so
  g++ -std=c++20 -O1 -fPIC -shared -s -DNDEBUG -fvisibility=hidden -fvisibility-inlines-hidden \
    -I "$headers" -I "$headers/python$version" -I "$(pybind11-config --cmakedir)/../../../include" \
    -I build/wheel/include/public python/module.cc "$content/skywave/libskywave.so.0" \
    -Wl,-rpath,"\$ORIGIN" -o "$content/skywave/_core.cpython-$short-x86_64-linux-gnu.so"
  sed -i -E "s/^Tag: .*/Tag: cp$short-cp$short-linux_x86_64/" "$content"/*.dist-info/WHEEL
  wheel pack "$content" --dest-dir "$folder/changed" >/dev/null
else
  echo "not built: the wheel for Python $version, whose headers come from a root of Debian 13"
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
echo "made in $((SECONDS - start)) s"
