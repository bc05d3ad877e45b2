#!/usr/bin/env bash
# Counts the instructions of every stage of a small render under callgrind and compares them with
# tests/baselines/instructions.txt; fails if one differs by more than 0.5 %, in either direction:
#   scripts/instruction_gate.sh [PROGRAM]                     default: build/release/skywave
#   scripts/instruction_gate.sh --update "REASON" [PROGRAM]   stores new counts with the reason
# It uses one thread, because waiting threads count too. Valgrind's processor has AVX2 and no
# AVX-512, so Highway dispatches to AVX2 by itself; Embree is given isa=avx2. Counts depend on the
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
command -v valgrind >/dev/null || skip "there is no valgrind (apt-get install valgrind)"
grep -qw avx2 /proc/cpuinfo || skip "the processor has no AVX2"

toolchain="$(c++ -dumpfullversion) $(dpkg-query -W -f='${Package}=${Version} ' \
  libembree-dev libhwy-dev libc6 libtbb-dev valgrind 2>/dev/null || true)"
if [[ -z $reason ]] && ! grep -qxF "# $toolchain" "$baseline"; then
  skip "the baseline is that of $(sed -n 's/^# \([0-9].*\)/\1/p' "$baseline" | head -1), not $toolchain"
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
(cd "$work" && valgrind --quiet --tool=callgrind --callgrind-out-file=out "$program" render spheres \
  --size 64x48 --spp 8 --threads 1 --embree-config isa=avx2 --quiet --output x.exr >&2)

# A function has one line for each file whose code was inlined into it; the largest is that of its
# own file and includes all of it.
callgrind_annotate --auto=no --inclusive=yes --threshold=100 "$work/out" |
  sed -nE 's/^ *([0-9,]+) .*:skywave::([A-Za-z:]+)\(.*/\1 \2/p' | tr -d , |
  awk 'BEGIN {
      split("GenerateRays generate TraceClosest intersect TraceEscapes intersect " \
            "SortHits partition MoveEscaped partition MoveSurfaces partition " \
            "ClassifyEscapes partition AddEscaped escape PrepareSurfaces surface " \
            "SampleLights light_sample EvaluateLights evaluate TraceShadows shadow " \
            "AddUnoccludedRadiance accumulate Scatter scatter Film::Add film " \
            "RenderPathWave wave", pair, " ")
      for (i = 1; i in pair; i += 2) stage[pair[i]] = pair[i + 1]
    }
    $2 in stage && $1 > most[$2] { most[$2] = $1 }
    END { for (name in most) sum[stage[name]] += most[name]
          for (name in sum) print name, sum[name] }' | sort > "$work/counts"
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
