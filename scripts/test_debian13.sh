#!/usr/bin/env bash
# Builds the program and the tests on Debian 13, whose Embree is version 4, and runs the tests:
#   scripts/test_debian13.sh [-DNAME=VALUE...]      options of CMake
# It does so in a root of that release, build/debian13/root, which is made once and kept. Warnings
# are errors. It prints the seconds of each part, and is skipped (77) where no root can be made:
# that takes Debian, mmdebstrap and the rights of root.
set -euo pipefail
cd "$(dirname "$0")/.."
# shellcheck source=scripts/debian_root.sh
. scripts/debian_root.sh

folder=$PWD/build/debian13
make_root trixie "$folder/root"

# The sources are a copy of the files that git knows, because tests must not depend on others and
# the root must not write here. Times are kept, so that only what has changed is compiled again.
rm -rf "$folder/source"
mkdir -p "$folder/source" "$folder/build"
git ls-files -z | tar --create --null --files-from=- | tar --extract --directory="$folder/source"
mkdir -p "$folder/source/build"
mounts=(--bind "$folder/source" /skywave --bind "$folder/build" /skywave/build)
settings=()
if command -v ccache >/dev/null; then
  cache=$(ccache --get-config cache_dir)
  mkdir -p "$cache"
  mounts+=(--bind "$cache" /ccache)
  settings+=(CCACHE_DIR=/ccache)
fi
# Runs a part of the work in the root and says how long it took.
part() {
  local name=$1 start=$SECONDS
  shift
  in_root "$folder/root" "${mounts[@]}" env --chdir=/skywave "${settings[@]}" "$@"
  echo "Debian 13: $name took $((SECONDS - start)) s"
}
jobs=${JOBS:-$(nproc)}
part packages scripts/setup.sh test
part configuration cmake --preset release -DSKYWAVE_BENCH=OFF -DSKYWAVE_WERROR=ON "$@"
part build cmake --build --preset release -j"$jobs" -- --quiet
# The result of these does not depend on the system, and they take minutes: a program with
# additions, the documents, and a cluster.
part tests ctest --test-dir build/release -LE "extension|docs|cluster" -j"$jobs" --output-on-failure
