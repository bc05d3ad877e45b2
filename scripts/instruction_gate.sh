#!/usr/bin/env bash
# Counts the instructions of every stage of small renders under callgrind, of paths, of paths from
# both ends, of photon maps and of textures, and compares them with
# tests/baselines/instructions.txt; fails if one differs by more than 0.1 %, in either direction:
#   scripts/instruction_gate.sh [PROGRAM]                     default: build/release/skywave
#   scripts/instruction_gate.sh --update "REASON" [PROGRAM]   stores new counts with the reason
# `skywave bench SCENE --instructions` counts (bench/measure/instructions.h). Counts depend on the
# compiler and on the versions of Embree, Highway and valgrind: if these differ from the baseline's,
# the gate is skipped, as it is without valgrind or AVX2 (exit code 77).
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
baseline=${SKYWAVE_INSTRUCTIONS:-$root/tests/baselines/instructions.txt}
limit_percent=0.1
# What is rendered, with the name that its stages get in the baseline.
pictures=(
  "path: spheres"
  "bdpt: spheres --integrator bdpt"
  "photon: spheres --integrator photon --photons 2000 --caustic-photons 2000 --gather 2"
  "textures: tests/data/textures.pbrt"
)
reason=
if [[ ${1:-} == --update ]]; then
  reason=${2:?"--update wants the reason for new counts"}
  shift 2
fi
program=$(realpath "${1:-$root/build/release/skywave}")
[[ -x $program ]] || { echo "no program: $program"; exit 64; }
skip() { echo "skipped: $1"; exit 77; }

toolchain="$(c++ -dumpfullversion) $(dpkg-query -W -f='${Package}=${Version} ' \
  libembree-dev libhwy-dev valgrind 2>/dev/null || true)"
if [[ -z $reason ]] && ! grep -qxF "# $toolchain" "$baseline"; then
  known=$(sed -n 's/^# \([0-9].*\)/\1/p' "$baseline" | head -1)
  skip "the baseline is that of $known, not $toolchain"
fi

work=$(mktemp -d)
# Where one picture fails, the others are still being counted.
running=()
stop() {
  local group
  for group in "${running[@]}"; do kill -- "-$group" 2>/dev/null || true; done
  wait
  rm -rf "$work"
}
trap stop EXIT
# Each is one process at a time that waits for nothing, so they can go side by side.
count() {
  local name=${1%%:*} arguments
  read -ra arguments <<< "${1#*:}"
  cd "$root"
  "$program" bench "${arguments[@]}" --instructions > "$work/$name.out" 2> "$work/$name.err"
}
set -m  # each is a group of processes: the program and its valgrind
for picture in "${pictures[@]}"; do
  count "$picture" < /dev/null &
  running+=($!)
done
set +m
for index in "${!pictures[@]}"; do
  name=${pictures[$index]%%:*}
  status=0
  wait "${running[$index]}" || status=$?
  unset "running[$index]"
  [[ $status -eq 0 ]] || { cat "$work/$name.out" "$work/$name.err"; exit "$status"; }
  sed "s,^,$name/," "$work/$name.out" >> "$work/counts"
done

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
  !($1 in expected) { bad += 1; printf "%-22s %12s %12d  NOT IN THE BASELINE\n", $1, "", $2; next }
  { change = 100 * ($2 / expected[$1] - 1)
    far = change > limit || change < -limit
    bad += far
    printf "%-22s %12d %12d %+9.4f %%%s\n", $1, expected[$1], $2, change, far ? "  BEYOND" : ""
    delete expected[$1] }
  END {
    for (stage in expected) {
      bad += 1
      printf "%-22s %12d  NOT FOUND: another name?\n", stage, expected[stage]
    }
    exit bad > 0 }' "$baseline" "$work/counts" || {
  echo "instructions differ by more than $limit_percent %; if they should:"
  echo "  scripts/instruction_gate.sh --update \"why\""
  exit 1; }
