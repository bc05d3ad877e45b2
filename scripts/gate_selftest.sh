#!/usr/bin/env bash
# Shows which gates detect a slower light sampling: a program that samples the given percentage of
# rows once more, for nothing. The sources have no such code; it is put into a copy of them:
#   scripts/gate_selftest.sh [PAIRS [PERCENT...]]
# PAIRS of runs for scripts/bench_compare.py (default: 12); PERCENT: 0, 100, 10 and 2 by default.
# Copies and builds in build/slowdown, where the program is skywave-PERCENT, for 0 too; takes about
# three minutes per percentage on an idle machine. Fails unless the unchanged program passes all gates, the
# instruction gate detects every slow-down, and the wall-clock gate those of 10 % and more.
set -euo pipefail
cd "$(dirname "$0")/.."
pairs=${1:-12}
percents=("${@:2}")
[[ ${#percents[@]} -gt 0 ]] || percents=(0 100 10 2)
scratch=build/slowdown
program() { echo "$scratch/skywave-$1"; }
# Has SampleLights sample PERCENT of the rows for nothing, by other random numbers, so that they
# read other texels and cost what samples cost, whatever the scene and the machine.
slow_down() {
  local file=wavefront/stages/stages.cc
  local call='  return SampleRows(frame, points, shares, call, n, uniforms, scratch, lights, places);'
  [[ $(grep -cxF "$call" "$file") -eq 1 ]] || { echo "$file: where is light sampling?" >&2; exit 1; }
  awk -v call="$call" -v percent="$1" '
    $0 == call && percent > 0 {
      print "  LightCall wasted = call;"
      print "  wasted.pair += kPairBlock * 4096;"
      print "  SampleRows(frame, points, shares, wasted, n * " percent " / 100, uniforms, scratch,"
      print "             lights, places);"
    }
    { print }' "$file" > "$scratch/source/$file"
}
build() {
  [[ $1 -le 100 ]] || { echo "$1 %: tables have no more rows than all" >&2; exit 64; }
  slow_down "$1"
  cmake --build "$scratch/build" -j"${JOBS:-2}" --target skywave -- --quiet >&2
  cp "$scratch/build/skywave" "$(program "$1")"
}
verdict() {
  local status=0
  "$@" > "$log" 2>&1 || status=$?
  case $status in
    0) echo passes ;;
    1) echo SEES ;;
    77) echo skipped ;;
    *) echo "error $status" ;;
  esac
}
log=$(mktemp)
trap 'rm -f "$log"' EXIT
wrong=0
mkdir -p "$scratch/source"
git ls-files -z | xargs -0 cp --parents --preserve=timestamps -t "$scratch/source"
cmake --preset program -S "$scratch/source" -B "$scratch/build" >/dev/null
build 0
for percent in "${percents[@]}"; do build "$percent"; done
printf '%-12s %-14s %-14s %s\n' "slow-down" counters instructions "wall clock ($pairs pairs, 5 %)"
for percent in "${percents[@]}"; do
  counters=$(verdict scripts/counter_gate.sh "$(program "$percent")")
  instructions=$(verdict scripts/instruction_gate.sh "$(program "$percent")")
  stage=$(awk '/^path\/light_sample/ { print $4 }' "$log")
  wall=$(verdict scripts/bench_compare.py --programs --pairs "$pairs" \
    "$(program 0)" "$(program "$percent")")
  printf '%-12s %-14s %-14s %s\n' "$percent %" "$counters" "$instructions $stage" "$wall"
  grep -E '^(COMPARE|stage|light sample)' "$log" | sed 's/^/  /' || true
  expected=SEES
  [[ $percent != 0 ]] || expected=passes
  [[ $instructions == "$expected" || $instructions == skipped ]] || wrong=1
  [[ $counters == passes || $counters == skipped ]] || wrong=1
  case $percent in
    0) [[ $wall == passes ]] || wrong=1 ;;
    *) [[ $percent -lt 10 || $wall == SEES ]] || wrong=1 ;;
  esac
done
exit "$wrong"
