#!/usr/bin/env bash
# Installs the Debian packages in clean systems and renders there as an unprivileged user:
#   scripts/test_packages.sh [RELEASE...]     default: the release of this machine
# For each release the packages are built by `cmake --workflow --preset package` (in a root of that
# release if it is not the one of this machine), installed by apt in a root that has no compiler, and
# a picture is rendered there, which has to be that of the build tree to the last byte. Then the
# examples are compiled against the installed library. Packages are left in build/packages/RELEASE.
# Skipped (77) without the rights to make roots (scripts/debian_root.sh).
set -euo pipefail
cd "$(dirname "$0")/.."
# shellcheck source=scripts/debian_root.sh
. scripts/debian_root.sh
own=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")
declare -A number=([bookworm]=12 [trixie]=13)
[[ $# -gt 0 ]] || set -- "$own"
picture=(render gallery --size 96x72 --spp 4 --threads 2 -q -o)
need_roots
fail() { echo "FAILED: $1" >&2; exit 1; }

# Builds the packages of a release, and a picture by the program of the build tree.
build_packages() {
  local release=$1 packages=$PWD/build/packages/$1 build=build/release
  rm -rf "$packages"
  mkdir -p "$packages"
  [[ $release == "$own" ]] || build=build/debian${number[$release]}/build/release
  rm -f "$build"/*.deb
  if [[ $release == "$own" ]]; then
    scripts/setup.sh python
    command -v dpkg-shlibdeps >/dev/null || fail "dpkg-dev is not installed"
    command -v file >/dev/null || fail "file is not installed"
    # The preset package changes the settings of build/release; they are put back afterwards.
    local preset=program
    ! grep -qs '^BUILD_TESTING:BOOL=ON' build/release/CMakeCache.txt || preset=release
    cmake --workflow --preset package > "$packages/build.log" ||
      { tail -n 50 "$packages/build.log" >&2; fail "$release: the packages were not built"; }
    build/release/skywave "${picture[@]}" "$packages/picture.exr"
    cmake --preset "$preset" >/dev/null
  else
    # The root, that of scripts/test_debian13.sh, sees this tree with a folder build/ of its own.
    local folder=$PWD/build/debian${number[$release]} cache
    local mounts=(--bind "$PWD" /skywave --bind "$folder/build" /skywave/build
                  --bind "$packages" /packages)
    mkdir -p "$folder/build"
    if command -v ccache >/dev/null; then
      cache=$(ccache --get-config cache_dir)
      mkdir -p "$cache"
      mounts+=(--bind "$cache" /ccache)
    fi
    make_root "$release" "$folder/root" dpkg-dev file
    in_root "$folder/root" "${mounts[@]}" env CCACHE_DIR=/ccache bash -ec '
      cd /skywave
      scripts/setup.sh python
      cmake --workflow --preset package > /packages/build.log ||
        { tail -n 50 /packages/build.log >&2; exit 1; }
      build/release/skywave "$@"' build "${picture[@]}" /packages/picture.exr
  fi
  mv "$build"/*.deb "$packages"
}

# Makes a root of a release with packages: build/roots/RELEASE-clean.
clean_root() {
  local release=$1 root=build/roots/$1-clean
  shift
  make_root "$release" "build/roots/$release"
  remove_root "$root"
  cp -a "build/roots/$release" "$root"
  install_in_root "$root" --bind "$PWD/build/packages/$release" /packages "$@"
}

test_packages() {
  local release=$1 packages=build/packages/$1 page
  inside() {
    in_root "build/roots/$release-clean" --bind "$PWD/$packages" /packages "$@"
  }
  # Prints the paths of packages in the root: apt takes them and installs what they depend on.
  files_of() { (cd "$packages" && printf '/packages/%s\n' $1); }

  mapfile -t files < <(files_of "skywave_*.deb libskywave[0-9]*.deb")
  clean_root "$release" "${files[@]}"
  inside setpriv --reuid=65534 --regid=65534 --clear-groups bash -c '
    cd "$(mktemp -d)" && skywave "$@" picture.exr && md5sum picture.exr picture.png
  ' render "${picture[@]}" > "$packages/installed.md5"
  (cd "$packages" && md5sum --quiet -c installed.md5) ||
    fail "$release: the installed program renders another picture than that of the build tree"
  for page in skywave skywave-render skywave-probe-info; do
    inside test -s "/usr/share/man/man1/$page.1.gz" || fail "$release: no manual page $page"
  done
  inside test -s /usr/share/zsh/vendor-completions/_skywave || fail "$release: no zsh completion"
  [[ $(inside bash -c '. /usr/share/bash-completion/completions/skywave
       COMP_WORDS=(skywave render --max-d) COMP_CWORD=2
       _skywave
       echo "${COMPREPLY[@]}"') == --max-depth ]] || fail "$release: no bash completion"
  echo "$release: the installed program renders the picture of the build tree"

  mapfile -t files < <(files_of "libskywave[0-9]*.deb python3-skywave*.deb")
  clean_root "$release" "${files[@]}"
  inside setpriv --reuid=65534 --regid=65534 --clear-groups bash -c '
    cd "$(mktemp -d)" && python3 -c "
import skywave
skywave.render(\"gallery\", size=(96, 72), spp=4, threads=2).save(\"picture.exr\")" &&
    md5sum picture.exr' > "$packages/python.md5"
  (cd "$packages" && md5sum --quiet -c python.md5) ||
    fail "$release: Python renders another picture than the program of the build tree"
  echo "$release: Python renders the picture of the build tree"

  mapfile -t files < <(files_of "libskywave*.deb")
  clean_root "$release" "${files[@]}" g++ cmake make pkg-config
  inside bash -ec '
    cp -r /usr/share/doc/skywave/examples /tmp/examples
    cmake -S /tmp/examples -B /tmp/build >/dev/null
    cmake --build /tmp/build >/dev/null
    [[ $(pkg-config --libs skywave) == *-lskywave* ]]
  ' || fail "$release: the examples do not compile against the installed library"
  echo "$release: the examples compile against the installed library"
  remove_root "build/roots/$release-clean"
}

for release in "$@"; do
  build_packages "$release"
  test_packages "$release"
done
