#!/usr/bin/env bash
# Checks the sources with .clang-format and .clang-tidy, and whether clang compiles them:
#   scripts/lint.sh format           every file; some seconds
#   scripts/lint.sh tidy [COUNT]     the units that differ from the branch main, 80 at most, and
#                                    others up to COUNT (default: 16), in rotation from commit to
#                                    commit
#   scripts/lint.sh tidy all         every unit; most of an hour on two cores
#   scripts/lint.sh tidy FILE...
#   scripts/lint.sh clang ...        likewise: clang accepts the units, and does not warn; fails
#                                    if none of them, or not each FILE, is built here
# Needs version 14 of all, because others format and warn differently. Skipped (77) if they are
# missing.
set -euo pipefail
cd "$(dirname "$0")/.."
skip() { echo "skipped: $1"; exit 77; }
tool() {
  local name
  for name in "$1-14" "$1"; do
    command -v "$name" >/dev/null || continue
    [[ $("$name" --version) =~ version\ 14\. ]] && echo "$name" && return
  done
}

if [[ ${1:-} == format ]]; then
  format=$(tool clang-format)
  [[ -n $format ]] || skip "there is no clang-format 14 (scripts/setup.sh test)"
  git ls-files -z '*.cc' '*.h' | xargs -0 "$format" --dry-run -Werror
  git ls-files -z '*.py' | xargs -0 awk '
    length > 100 { print FILENAME ":" FNR ": more than 100 columns" > "/dev/stderr"; wide = 1 }
    END { exit wide }'
  echo "formatted as .clang-format says"
  exit 0
fi
case ${1:-} in
  tidy) program=clang-tidy ;;
  clang) program=clang++ ;;
  *) sed -n '2,/^[^#]/s/^# \?//p' "$0" >&2; exit 64 ;;
esac
program=$(tool "$program")
[[ -n $program ]] || skip "there is no $1 14 (scripts/setup.sh test)"
# Units are looked at one by one, also those that a build compiles together.
cmake --preset release -B build/lint -DSKYWAVE_UNITY=OFF >/dev/null
# clang cannot read headers that g++ has precompiled, and does not know all of its warnings.
database=$(mktemp -d)
trap 'rm -rf "$database"' EXIT
sed -E 's/ -Winvalid-pch//; s/ -fpch-preprocess//; s/ -include [^ ]*cmake_pch\.hxx//' \
  build/lint/compile_commands.json > "$database/compile_commands.json"

units=()
named=
if [[ ${2:-} == all ]]; then
  mapfile -t units < <(git ls-files '*.cc' ':!scripts/tables' ':!tests/fuzz/libfuzzer.cc')
elif [[ ${2:-16} =~ ^[0-9]+$ ]]; then
  count=${2:-16}
  base=$(git merge-base HEAD origin/main 2>/dev/null || git merge-base HEAD main 2>/dev/null ||
    true)
  [[ -n $base && $base != "$(git rev-parse HEAD)" ]] || base=HEAD~1
  mapfile -t all < <(git ls-files '*.cc' ':!scripts/tables' ':!tests/fuzz/libfuzzer.cc')
  mapfile -t units < <(git diff --name-only --diff-filter=d "$base" -- '*.cc' ':!scripts/tables' \
    ':!tests/fuzz/libfuzzer.cc' 2>/dev/null || true)
  start=$(($(git rev-list --count HEAD) * count % ${#all[@]}))
  changed=$((${#units[@]} < 80 ? ${#units[@]} : 80))
  count=$((count > changed ? count : changed))
  units+=("${all[@]:start}" "${all[@]:0:start}")
  mapfile -t units < <(printf '%s\n' "${units[@]}" | awk '!seen[$0]++' | head -n "$count")
else
  named=1
  units=("${@:2}")
fi
# Checks one unit; prints what clang says of it.
check() {
  local command
  if [[ $kind == tidy ]]; then
    "$program" --quiet -p "$database" --extra-arg=-Wno-unknown-warning-option "$1" \
      2> >(grep -v 'warnings\? generated' >&2)
    return
  fi
  # The command of the build, by another compiler that writes nothing.
  command=$(python3 -c 'import json, sys
for unit in json.load(open(sys.argv[1])):
    if unit["file"] == sys.argv[2]:
        print(unit["command"].partition(" ")[2])
        break' "$database/compile_commands.json" "$PWD/$1")
  [[ -n $command ]] || { echo "$1 is not built" | tee -a "$database/missing"; return; }
  (cd build/lint && eval "$program -fsyntax-only -Werror -Wno-unknown-warning-option $command")
}
export kind=$1 program database
export -f check
touch "$database/missing"
printf '%s\0' "${units[@]}" |
  xargs -0 -P "${JOBS:-$(nproc)}" -I '{}' bash -c 'check "$1"' check '{}'
missing=$(wc -l < "$database/missing")
found=$((${#units[@]} - missing))
echo "$found units: $1 has nothing to say; $missing are not built here"
[[ $found -gt 0 && ( -z $named || $missing -eq 0 ) ]]
