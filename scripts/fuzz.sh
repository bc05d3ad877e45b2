#!/usr/bin/env bash
# Fuzzes every reader for MINUTES each, under the address and undefined-behaviour sanitizers: with
# libFuzzer if there is a clang that has it (Debian's clang-14 with libclang-rt-14-dev, say), else
# with the plain driver, as the first line says. "fuzz.sh MINUTES READER..." fuzzes these. Ends with
# the first crash; libFuzzer leaves the input in build/libfuzzer.
set -euo pipefail
cd "$(dirname "$0")/.."
minutes=${1:?usage: fuzz.sh MINUTES [READER...]}
shift
readers=("$@")
[[ ${#readers[@]} -gt 0 ]] || mapfile -t readers < <(ls tests/fuzz/corpus)
seconds=$(awk "BEGIN { print int(60 * $minutes) }")
# Readers hardly use the kernels, so those are compiled for one instruction set only.
common=(-G Ninja -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -g1"
        -DCMAKE_CXX_FLAGS=-DHWY_COMPILE_ONLY_STATIC -DSKYWAVE_SANITIZE=address,undefined
        -DSKYWAVE_SANITIZE_KERNELS=OFF -DBUILD_TESTING=ON)
# Prints the newest clang++ that links libFuzzer.
clang_with_libfuzzer() {
  local name
  for name in clang++ $(compgen -c clang++- | grep -E '^clang\+\+-[0-9]+$' | sort -urV); do
    command -v "$name" >/dev/null || continue
    echo 'extern "C" int LLVMFuzzerTestOneInput(const char*, unsigned long) { return 0; }' |
      "$name" -x c++ -fsanitize=fuzzer,address - -o /dev/null 2>/dev/null && echo "$name" && return
  done
}
clang=$(clang_with_libfuzzer)
if [[ -n $clang ]]; then
  echo "fuzzing with the libFuzzer of $clang"
  cmake -B build/libfuzzer "${common[@]}" -DCMAKE_CXX_COMPILER="$clang" -DSKYWAVE_FUZZ=ON
  cmake --build build/libfuzzer -j "${JOBS:-2}" --target "${readers[@]/#/fuzz_}"
  for reader in "${readers[@]}"; do
    mkdir -p "build/libfuzzer/corpus/$reader"
    (cd build/libfuzzer && "tests/fuzz_$reader" -max_total_time="$seconds" -rss_limit_mb=4096 \
      -timeout=60 "corpus/$reader" "../../tests/fuzz/corpus/$reader")
  done
else
  echo "fuzzing with the plain driver: no clang++ here links libFuzzer"
  cmake -B build/fuzz "${common[@]}"
  cmake --build build/fuzz -j "${JOBS:-2}" --target reader_fuzz
  for reader in "${readers[@]}"; do
    build/fuzz/tests/reader_fuzz "$reader" "tests/fuzz/corpus/$reader" --seconds "$seconds" \
      --seed "${SEED:-$RANDOM}"
  done
fi
