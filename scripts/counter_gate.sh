#!/usr/bin/env bash
# Compares the counters of the suite (rays, rows, bytes, hashes) with those in tests/baselines, to
# the last digit. Each vendor's processors have a file, because their hits have other bits
# (docs/design.md): bench_counters_intel.txt and bench_counters_amd.txt.
#   scripts/counter_gate.sh [PROGRAM]            fails if a line differs
#   scripts/counter_gate.sh --update [PROGRAM]   stores the new counters; the commit says why
# Skipped (77) where there is no file of the vendor, and on processors without AVX2.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
update=0
if [[ ${1:-} == --update ]]; then
  update=1
  shift
fi
program=${1:-$root/build/release/skywave}
if ! grep -qw avx2 /proc/cpuinfo; then
  echo "skipped: the counters are those of a processor with AVX2"
  exit 77
fi
case $(sed -n '/^vendor_id/ { s/.*: //p; q }' /proc/cpuinfo) in
  AuthenticAMD) counters_of=bench_counters_amd.txt ;;
  GenuineIntel) counters_of=bench_counters_intel.txt ;;
  *)
    echo "skipped: there are no counters of this vendor's processors with AVX2"
    exit 77
    ;;
esac
baseline=${SKYWAVE_COUNTERS:-$root/tests/baselines/$counters_of}
if [[ $update == 0 && ! -e $baseline ]]; then
  echo "skipped: there are no counters of this vendor's processors yet; take them: $0 --update"
  exit 77
fi
counters=$(mktemp)
trap 'rm -f "$counters"' EXIT
status=0
"$program" bench --counters > "$counters" || status=$?
if [[ $update == 1 ]]; then
  cp "$counters" "$baseline"
  echo "wrote $baseline; say in the commit why the counters changed"
  exit 0
fi
if ! diff -u --label committed --label "this build" "$baseline" "$counters"; then
  echo "counters differ; if they should: scripts/counter_gate.sh --update, and the reason in the commit"
  exit 1
fi
[[ $status == 0 ]] || exit "$status"
echo "counters as committed"
