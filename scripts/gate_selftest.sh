#!/usr/bin/env bash
# Shows which gates detect a slower light sampling: a build that samples the given percentage of
# rows once more, for nothing (wavefront/stages/stages.cc):
#   scripts/gate_selftest.sh [PAIRS [PERCENT...]]
# PAIRS of runs for scripts/bench_compare.py (default: 12); PERCENT: 0, 100, 10 and 2 by default.
# Builds the program into build/slowdown-PERCENT, for 0 too; takes about three minutes per
# percentage on an idle machine. Fails unless the unchanged program passes all gates, the
# instruction gate detects every slow-down, and the wall-clock gate those of 10 % and more.
set -euo pipefail
cd "$(dirname "$0")/.."
pairs=${1:-12}
percents=("${@:2}")
[[ ${#percents[@]} -gt 0 ]] || percents=(0 100 10 2)
folder() { echo "build/slowdown-$1"; }
build() {
  cmake --preset program -B "$(folder "$1")" -DSKYWAVE_SLOWDOWN="${1/#0/}" >/dev/null
  cmake --build "$(folder "$1")" -j"${JOBS:-2}" --target skywave -- --quiet >&2
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
build 0
for percent in "${percents[@]}"; do build "$percent"; done
printf '%-12s %-14s %-14s %s\n' "slow-down" counters instructions "wall clock ($pairs pairs, 5 %)"
for percent in "${percents[@]}"; do
  counters=$(verdict scripts/counter_gate.sh "$(folder "$percent")/skywave")
  instructions=$(verdict scripts/instruction_gate.sh "$(folder "$percent")/skywave")
  stage=$(awk '/^path\/light_sample/ { print $4 }' "$log")
  wall=$(verdict scripts/bench_compare.py --programs --pairs "$pairs" \
    "$(folder 0)/skywave" "$(folder "$percent")/skywave")
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
