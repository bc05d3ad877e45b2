#!/usr/bin/env bash
# Makes the folder that runs anywhere (scripts/build_folder.sh) and uses it where there is nothing:
#   scripts/test_folder.sh [RELEASE...]     bookworm, trixie; default: both
# For each release it is unpacked in a root of a minimal system by an unprivileged user without
# network. Its pictures have to be those of the build tree to the last byte, and whatever keeps it
# from running has to be said in one sentence. Prints seconds. Skipped (77) without the rights to
# make roots (scripts/debian_root.sh).
set -euo pipefail
cd "$(dirname "$0")/.."
# shellcheck source=scripts/debian_root.sh
. scripts/debian_root.sh
need_roots
[[ $# -gt 0 ]] || set -- bookworm trixie
picture=(render gallery --size 96x72 --spp 4 --threads 2 -q -o)
preset=program
! grep -qs '^BUILD_TESTING:BOOL=ON' build/release/CMakeCache.txt || preset=release
scripts/build_folder.sh
build/release/skywave "${picture[@]}" build/portable/picture.exr
cmake --preset "$preset" >/dev/null

for release in "$@"; do
  make_root "$release" "build/roots/$release"
  in_root "build/roots/$release" --bind "$PWD/build/portable" /portable unshare --net \
    setpriv --reuid=65534 --regid=65534 --clear-groups bash -e -c '
      fail() { echo "FAILED: $1" >&2; exit 1; }
      # Archives are unpacked here, because a minimal system has no xz; the user has no rights there.
      mkdir -p "/tmp/a folder"
      cd "/tmp/a folder"
      rm -rf ./*
      cp -r /portable/skywave-*-linux-x86_64 here
      mkdir bin elsewhere
      ln -s ../here/skywave bin/skywave
      same() {
        [[ $(md5sum < picture.exr) == $(md5sum < /portable/picture.exr) &&
           $(md5sum < picture.png) == $(md5sum < /portable/picture.png) ]] ||
          fail "$1 renders another picture than the build tree"
        rm picture.*
      }
      start=$(date +%s.%N)
      here/skywave "$@" picture.exr
      rendered=$(date +%s.%N)
      same "the folder"
      bin/skywave "$@" picture.exr
      same "a link to its program"
      mv here elsewhere/moved
      elsewhere/moved/skywave "$@" picture.exr
      same "the folder at another place"
      mv elsewhere/moved here
      for file in LICENSE libembree3-3.txt libtbb12.txt; do
        [[ -s here/share/doc/licences/$file ]] || fail "the folder has no licence $file"
      done
      for file in here/lib/*; do
        ! ldd "$file" | grep "not found" || fail "$file lacks a library"
        # Apart from glibc, everything comes from the folder.
        ! ldd "$file" | grep "=> /" | grep -vE "=> (/tmp/a folder/here/lib/|.*/(libc|libm)\.so)" ||
          fail "$file takes a library of the system"
      done

      # What keeps it from running is one sentence, and exit code 1.
      refuses() {
        local said status=0
        said=$(here/skywave info gallery 2>&1) || status=$?
        [[ $status -eq 1 && $said == "skywave: "*"$1"* && $said != *$'"'\\n'"'* ]] ||
          fail "expected one sentence with \"$1\" and exit code 1, got $status and: $said"
      }
      library=$(basename here/lib/libembree*)
      mv "here/lib/$library" kept
      refuses "$library is missing or damaged; unpack the archive again"
      head -c 1000 kept > "here/lib/$library"
      refuses "$library is missing or damaged; unpack the archive again"
      mv kept "here/lib/$library"
      mv here/lib/.sizes kept
      refuses "sizes is missing; unpack the archive again"
      mv kept here/lib/.sizes
      mkdir fake
      PATH=$PWD/fake:$PATH
      lie() {
        printf "#!/bin/sh\n%s\n" "$2" > "fake/$1"
        chmod 755 "fake/$1"
      }
      lie getconf "echo glibc 2.31"
      refuses "or newer, and this is glibc 2.31"
      lie getconf "exit 1"
      refuses "or newer, and this is a system without it"
      rm fake/getconf
      lie uname "echo Linux aarch64"
      refuses "for Linux x86_64, and this is Linux aarch64"
      rm fake/uname
      lie grep "exit 1"
      refuses "a processor with AVX2"
      rm fake/grep
      here/skywave info gallery > /dev/null || fail "the folder does not run again"
      echo "'"$release"': first picture in $(awk "BEGIN { printf \"%.1f\", $rendered - $start }") s, bytes equal"
    ' test "${picture[@]}"
done
