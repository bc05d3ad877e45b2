#!/usr/bin/env bash
# Makes the environments of bench/peers/peers.py: the programs that come as Python packages, each in
# a virtual environment of its own, because they need different versions of others.
#   bench/peers/setup.sh [NAME...]     blender mitsuba luxcore radiance llvm; without names all
# They take 3 GB in $SKYWAVE_PEERS (default: skywave-peers in the user's cache). Each gets the first
# Python that it is published for: those of $SKYWAVE_PYTHONS, then those of the PATH from the newest
# on. What cannot be installed is reported at the end, with exit code 1; peers.py does without it.
# Nothing needs root, and `rm -r` of the folder removes everything.
set -uo pipefail
folder=${SKYWAVE_PEERS:-${XDG_CACHE_HOME:-$HOME/.cache}/skywave-peers}
mkdir -p "$folder" && folder=$(cd "$folder" && pwd) || exit 1
[[ $# -gt 0 ]] || set -- blender mitsuba luxcore radiance llvm

pythons=()
for python in ${SKYWAVE_PYTHONS:-} python3.{15..10} python3; do
  if "$python" -c "import venv, ensurepip" 2>/dev/null; then pythons+=("$python"); fi
done
problems=()

# install NAME PACKAGE MODULE: into $folder/NAME, by the first Python that works.
install() {
  local name=$1 package=$2 module=$3 log=$folder/$1.log
  if "$folder/$name/bin/python" -c "import $module" >/dev/null 2>&1; then
    echo "$name: already there"
    return
  fi
  : > "$log"
  for python in "${pythons[@]}"; do
    rm -rf "${folder:?}/$name"
    if "$python" -m venv "$folder/$name" >>"$log" 2>&1 &&
       "$folder/$name/bin/pip" install --quiet --disable-pip-version-check --no-input \
         --only-binary :all: "$package" >>"$log" 2>&1 &&
       "$folder/$name/bin/python" -c "import $module" >>"$log" 2>&1; then
      echo "$name: $("$folder/$name/bin/pip" list 2>/dev/null | grep -i "^$package ")," \
        "$("$folder/$name/bin/python" --version)"
      return
    fi
  done
  rm -rf "${folder:?}/$name"
  problems+=("$name: no version of $package could be installed and imported: $log")
}

# Mitsuba's compiled variants need an LLVM that is newer than Debian 12's default.
install_llvm() {
  local package=libllvm19 hint="set DRJIT_LIBLLVM_PATH to the file of a newer LLVM than 15"
  if compgen -G "$folder/llvm/usr/lib/*/libLLVM*" >/dev/null; then
    echo "llvm: already there"
  elif ! command -v apt-get >/dev/null; then
    problems+=("llvm: no apt-get here; $hint")
  elif mkdir -p "$folder/llvm" &&
       (cd "$folder/llvm" && apt-get -qq download "$package" && dpkg -x "$package"_*.deb . &&
        rm "$package"_*.deb) >"$folder/llvm.log" 2>&1; then
    echo "llvm: $package"
  else
    problems+=("llvm: $package could not be downloaded: $folder/llvm.log; $hint")
  fi
}

for name in "$@"; do
  case $name in
    blender) install blender bpy bpy ;;
    mitsuba) install mitsuba mitsuba mitsuba ;;
    luxcore) install luxcore pyluxcore pyluxcore ;;
    radiance) install radiance pyradiance pyradiance ;;
    llvm) install_llvm ;;
    *) echo "unknown: $name (blender, mitsuba, luxcore, radiance, llvm)" >&2; exit 64 ;;
  esac
done
if [[ ${#problems[@]} -gt 0 ]]; then
  printf '%s\n' "could not be installed:" "${problems[@]}" >&2
  exit 1
fi
