#!/usr/bin/env bash
# Checks the sources with .clang-format and .clang-tidy:
#   scripts/lint.sh format           every file; some seconds
#   scripts/lint.sh tidy [COUNT]     COUNT units (default: 16): those that differ from the branch
#                                    main first, then others, in rotation from commit to commit
#   scripts/lint.sh tidy all         every unit; most of an hour on two cores
#   scripts/lint.sh tidy FILE...
# Needs version 14 of both, because others format and warn differently. Skipped (77) if they are
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
  echo "formatted as .clang-format says"
  exit 0
fi
[[ ${1:-} == tidy ]] || { sed -n '2,8s/^# \?//p' "$0" >&2; exit 64; }

tidy=$(tool clang-tidy)
[[ -n $tidy ]] || skip "there is no clang-tidy 14 (scripts/setup.sh test)"
# Units are looked at one by one, also those that a build compiles together.
cmake --preset release -B build/lint -DSKYWAVE_UNITY=OFF >/dev/null
# clang cannot read headers that g++ has precompiled, and does not know all of its warnings.
database=$(mktemp -d)
trap 'rm -rf "$database"' EXIT
sed -E 's/ -Winvalid-pch//; s/ -fpch-preprocess//; s/ -include [^ ]*cmake_pch\.hxx//' \
  build/lint/compile_commands.json > "$database/compile_commands.json"

units=()
if [[ ${2:-} == all ]]; then
  mapfile -t units < <(git ls-files '*.cc' ':!tools' ':!tests/fuzz/libfuzzer.cc')
elif [[ ${2:-16} =~ ^[0-9]+$ ]]; then
  count=${2:-16}
  base=$(git merge-base HEAD origin/main 2>/dev/null || git merge-base HEAD main 2>/dev/null || true)
  [[ -n $base && $base != "$(git rev-parse HEAD)" ]] || base=HEAD~1
  mapfile -t all < <(git ls-files '*.cc' ':!tools' ':!tests/fuzz/libfuzzer.cc')
  mapfile -t units < <(git diff --name-only --diff-filter=d "$base" -- '*.cc' ':!tools' \
    ':!tests/fuzz/libfuzzer.cc' 2>/dev/null || true)
  start=$(($(git rev-list --count HEAD) * count % ${#all[@]}))
  units+=("${all[@]:start}" "${all[@]:0:start}")
  mapfile -t units < <(printf '%s\n' "${units[@]}" | awk '!seen[$0]++' | head -n "$count")
else
  units=("${@:2}")
fi
printf '%s\0' "${units[@]}" |
  xargs -0 -n 1 -P "${JOBS:-$(nproc)}" "$tidy" --quiet -p "$database" \
    --extra-arg=-Wno-unknown-warning-option 2> "$database/log" ||
  { grep -v 'warnings\? generated' "$database/log" >&2; exit 1; }
echo "${#units[@]} units are tidy"
