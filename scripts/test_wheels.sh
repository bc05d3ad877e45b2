#!/usr/bin/env bash
# Makes the wheels (scripts/build_wheels.sh) and uses them where there is nothing but Python:
#   scripts/test_wheels.sh [RELEASE...]     bookworm, trixie, forky; default: the first two
# For each release pip installs one in a virtual environment of a root that has python3-venv, by an
# unprivileged user, without network and compilers. The pictures of the module and of the command
# have to be those of the build tree to the last byte, and the tests of the package pass. Prints size
# and seconds. Skipped (77) without the rights to make roots (scripts/debian_root.sh).
set -euo pipefail
cd "$(dirname "$0")/.."
# shellcheck source=scripts/debian_root.sh
. scripts/debian_root.sh
need_roots
fail() { echo "FAILED: $1" >&2; exit 1; }
# Which Python a release has, the wheel that pip should choose for it, and what that was made with.
declare -A python=([bookworm]=3.11 [trixie]=3.13 [forky]=3.14)
declare -A wheel=([bookworm]=cp311-cp311 [trixie]=cp312-abi3 [forky]=cp312-abi3)
declare -A binding=([bookworm]=pybind11 [trixie]=nanobind [forky]=nanobind)
[[ $# -gt 0 ]] || set -- bookworm trixie
folder=$PWD/build/portable
picture=(render gallery --size 96x72 --spp 4 --threads 2 -q -o)
scripts/build_wheels.sh
# shellcheck source=scripts/bundle.sh
. scripts/bundle.sh
scripts/build.sh
build/release/skywave "${picture[@]}" "$folder/picture.exr"

for release in "$@"; do
  version=${python[$release]}
  # What pip would fetch from PyPI; embreex and OpenEXR bring libraries that the wheel has too.
  mkdir -p "$folder/packages"
  for package in numpy embreex openexr; do
    compgen -G "$folder/packages/$package-*-cp${version/./}-*" >/dev/null ||
      "$tools/bin/pip" download --quiet --disable-pip-version-check --no-deps --only-binary :all: \
        --python-version "$version" --dest "$folder/packages" "$package"
  done
  make_root "$release" "build/roots/$release-python" python3-venv
  in_root "build/roots/$release-python" --bind "$folder" /portable \
    --bind "$PWD/tests/python" /mnt unshare --net \
    setpriv --reuid=65534 --regid=65534 --clear-groups bash -e -c '
      fail() { echo "FAILED: $1" >&2; exit 1; }
      cd "$(mktemp -d)"
      export HOME=$PWD
      ! command -v cc g++ || fail "the root has a compiler"
      python3 -m venv of_pip
      PATH=$PWD/of_pip/bin:$PATH
      pip="pip --disable-pip-version-check --no-cache-dir"
      start=$(date +%s.%N)
      $pip install --quiet --no-index --find-links /portable/packages --find-links /portable/wheels \
        skywave
      installed=$(date +%s.%N)
      skywave "$@" picture.exr
      rendered=$(date +%s.%N)
      [[ $(md5sum < picture.exr) == $(md5sum < /portable/picture.exr) ]] ||
        fail "the command renders another picture than the build tree"
      [[ $(md5sum < picture.png) == $(md5sum < /portable/picture.png) ]] ||
        fail "the command writes another PNG than the build tree"
      rm picture.*
      python3 -c "
import skywave
skywave.render(\"gallery\", size=(96, 72), spp=4, threads=2).save(\"picture.exr\")"
      [[ $(md5sum < picture.exr) == $(md5sum < /portable/picture.exr) ]] ||
        fail "the module renders another picture than the build tree"
      # The least of some runs is the time without what else the machine does.
      import=$(for run in 1 2 3 4 5; do
        python3 -c "
import time
start = time.perf_counter()
import skywave
print(\"%.2f\" % (time.perf_counter() - start))"
      done | sort -n | head -1)
      awk "BEGIN { exit !($import <= 0.3) }" || fail "import skywave takes $import s"

      # Licences of what the wheel brings along, and of Skywave.
      licences=$(echo of_pip/lib/python3*/site-packages/skywave-*.dist-info/licenses)
      for file in LICENSE Apache-2.0 libembree3-3.txt libtbb12.txt '"${binding[$release]}"'.txt; do
        [[ -s $licences/$file ]] || fail "the wheel has no licence $file"
      done
      # Nothing may come from the system but what the policy of such wheels takes for granted.
      for file in of_pip/lib/python3*/site-packages/skywave{.libs/*,/*.so*,/bin/*}; do
        ! ldd "$file" | grep "not found" || fail "$file lacks a library"
      done

      # pip says in a sentence that it has no wheel for another Python, or for an older glibc.
      for wheel in /portable/wheels/*.whl; do
        [[ $wheel != *-'"${wheel[$release]}"'-* ]] || continue
        ! $pip install --no-index --no-deps "$wheel" > refused 2>&1 || fail "pip took $wheel"
        [[ $(grep -c . refused) -eq 1 ]] || { cat refused; fail "pip says more than a sentence"; }
      done
      # The tests of the package, which need nothing else of the tree.
      for test in render scene bad_input interrupt; do
        python3 -B -W ignore /mnt/${test}_test.py > tests.log 2>&1 ||
          { cat tests.log; fail "${test}_test.py fails"; }
      done
      # Other packages with Embree and OpenEXR in the same process, in any order.
      $pip install --quiet --no-index --no-deps --find-links /portable/packages embreex OpenEXR
      python3 -B -W ignore /mnt/imports_test.py > tests.log 2>&1 ||
        { cat tests.log; fail "imports_test.py fails"; }
      # A wheel that lost its program.
      rm of_pip/lib/python3*/site-packages/skywave/bin/skywave
      ! skywave info > refused 2>&1 || fail "the command ran without its program"
      [[ $(cat refused) == *"install the wheel again" ]] || { cat refused; fail "no clear sentence"; }
      echo "'"$release"', Python '"$version"': installed in $(awk "BEGIN { printf \"%.1f\", $installed - $start }") s," \
        "first picture in $(awk "BEGIN { printf \"%.1f\", $rendered - $installed }") s, import in $import s, bytes equal"
    ' test "${picture[@]}"
done
