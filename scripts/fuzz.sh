#!/usr/bin/env bash
# Fuzzes every reader for MINUTES each, under the address and undefined-behaviour sanitizers: with
# clang's libFuzzer if clang is available, else with the plain driver. "fuzz.sh MINUTES READER"
# fuzzes one. Ends with the first crash; libFuzzer leaves the input in build/fuzz.
set -euo pipefail
cd "$(dirname "$0")/.."
minutes=${1:?usage: fuzz.sh MINUTES [READER...]}
shift
readers=("$@")
[[ ${#readers[@]} -gt 0 ]] || readers=($(ls tests/fuzz/corpus))
seconds=$(awk "BEGIN { print int(60 * $minutes) }")
# Readers hardly use the kernels, so those are compiled for one instruction set only.
common=(-G Ninja -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -g1"
        -DCMAKE_CXX_FLAGS=-DHWY_COMPILE_ONLY_STATIC -DSKYWAVE_SANITIZE=address,undefined
        -DSKYWAVE_SANITIZE_KERNELS=OFF -DBUILD_TESTING=ON)
if echo 'extern "C" int LLVMFuzzerTestOneInput(const char*, unsigned long) { return 0; }' |
   clang++ -x c++ -fsanitize=fuzzer,address - -o /dev/null 2>/dev/null; then
  cmake -B build/fuzz "${common[@]}" -DCMAKE_CXX_COMPILER=clang++ -DSKYWAVE_FUZZ=ON
  for reader in "${readers[@]}"; do
    cmake --build build/fuzz -j "${JOBS:-2}" --target "fuzz_$reader"
    mkdir -p "build/fuzz/corpus/$reader"
    (cd build/fuzz && "tests/fuzz_$reader" -max_total_time="$seconds" -rss_limit_mb=4096 -timeout=60 \
      "corpus/$reader" "../../tests/fuzz/corpus/$reader")
  done
else
  cmake -B build/fuzz "${common[@]}"
  cmake --build build/fuzz -j "${JOBS:-2}" --target reader_fuzz
  for reader in "${readers[@]}"; do
    build/fuzz/tests/reader_fuzz "$reader" "tests/fuzz/corpus/$reader" --seconds "$seconds" \
      --seed "${SEED:-$RANDOM}"
  done
fi
