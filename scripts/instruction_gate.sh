#!/usr/bin/env bash
# Counts the instructions of every stage of a small render under callgrind and compares them with
# tests/baselines/instructions.txt; fails if one differs by more than 0.5 %, in either direction:
#   scripts/instruction_gate.sh [PROGRAM]                     default: build/release/skywave
#   scripts/instruction_gate.sh --update "REASON" [PROGRAM]   stores new counts with the reason
# `skywave bench spheres --instructions` counts (measure/instructions.h). Counts depend on the
# compiler and the libraries: if these differ from the baseline's, the gate is skipped, as it is
# without valgrind or AVX2 (exit code 77).
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
baseline=${SKYWAVE_INSTRUCTIONS:-$root/tests/baselines/instructions.txt}
limit_percent=0.5
reason=
if [[ ${1:-} == --update ]]; then
  reason=${2:?"--update wants the reason for new counts"}
  shift 2
fi
program=$(realpath "${1:-$root/build/release/skywave}")
[[ -x $program ]] || { echo "no program: $program"; exit 64; }
skip() { echo "skipped: $1"; exit 77; }

toolchain="$(c++ -dumpfullversion) $(dpkg-query -W -f='${Package}=${Version} ' \
  libembree-dev libhwy-dev libc6 libtbb-dev valgrind 2>/dev/null || true)"
if [[ -z $reason ]] && ! grep -qxF "# $toolchain" "$baseline"; then
  skip "the baseline is that of $(sed -n 's/^# \([0-9].*\)/\1/p' "$baseline" | head -1), not $toolchain"
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$program" bench spheres --instructions > "$work/counts" || {
  status=$?; cat "$work/counts"; exit "$status"; }
[[ $(wc -l < "$work/counts") == 12 ]] || {
  echo "not every stage was found; has a function another name?"; cat "$work/counts"; exit 1; }

if [[ -n $reason ]]; then
  [[ ! -f $baseline ]] || grep '^## ' "$baseline" > "$work/reasons" || true
  { echo "# Instructions of each stage: scripts/instruction_gate.sh. Compiler and libraries:"
    echo "# $toolchain"
    echo "# Reasons for new counts, the last one last:"
    cat "$work/reasons" 2>/dev/null || true
    echo "## $reason"
    cat "$work/counts"; } > "$work/new"
  mv "$work/new" "$baseline"
  echo "wrote $baseline"
  exit 0
fi
awk -v limit="$limit_percent" '
  FNR == NR { if ($1 !~ /^#/) expected[$1] = $2; next }
  { change = 100 * ($2 / expected[$1] - 1)
    far = change > limit || change < -limit
    bad += far
    printf "%-14s %12d %12d %+9.4f %%%s\n", $1, expected[$1], $2, change, far ? "  BEYOND" : "" }
  END { exit bad > 0 }' "$baseline" "$work/counts" || {
  echo "instructions differ by more than $limit_percent %; if they should:"
  echo "  scripts/instruction_gate.sh --update \"why\""
  exit 1; }
