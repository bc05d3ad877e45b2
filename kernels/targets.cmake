# Instruction sets of skywave_kernels, by SKYWAVE_TARGETS. Each is a compilation of every kernel, with
# the same bits. AVX2 and AVX-512 are enough for processors since 2013 (Intel) and 2015 (AMD); the
# other sets bring less than the noise in time. The lowest set is the baseline, which is what Highway
# takes for granted, so that nothing is compiled for less (RequireKernelTarget). Only kernels are
# compiled for it.
#
# One set alone takes half of the time, is called without dispatch, and lets Highway's headers be
# precompiled (highway_headers), which two sets read twice. For sanitizers it is AVX2, because they look
# at what the sets share.
#
# Numbers instead of names, because Highway 1.0 does not know the younger ones: SSSE3, SSE4, AVX3_DL,
# AVX3_ZEN4 and AVX3_SPR of hwy/detect_targets.h.
set(disabled_targets "(1LL<<12)")
set(one_target "")
if(SKYWAVE_SANITIZE)
  set(one_target AVX2)
elseif(SKYWAVE_TARGETS MATCHES "^AVX[23]$")
  set(one_target ${SKYWAVE_TARGETS})
elseif(SKYWAVE_TARGETS STREQUAL here)
  try_run(SKYWAVE_AVX3_STATUS SKYWAVE_AVX3_COMPILES SOURCE_FROM_CONTENT processor.cc
    "#include <hwy/targets.h>
int main() { return (hwy::SupportedTargets() & HWY_AVX3) != 0 ? 0 : 1; }"
    LINK_LIBRARIES hwy::hwy)
  set(one_target AVX2)
  if(SKYWAVE_AVX3_STATUS EQUAL 0)
    set(one_target AVX3)
  endif()
elseif(NOT SKYWAVE_TARGETS MATCHES "^(all)?$")
  message(FATAL_ERROR "SKYWAVE_TARGETS=${SKYWAVE_TARGETS}: it is AVX2, AVX3, here, all, or empty")
endif()
if(one_target OR SKYWAVE_TARGETS STREQUAL "")
  set(lowest_target AVX2)
  if(one_target)
    set(lowest_target ${one_target})
    set(highway_headers <hwy/foreach_target.h> <hwy/highway.h>)
    string(APPEND disabled_targets "|((HWY_AVX2|HWY_AVX3)&~HWY_${one_target})")
    target_compile_definitions(skywave_kernels PRIVATE HWY_COMPILE_ONLY_STATIC)
    # g++ forgets in precompiled headers that its intrinsics leave undefined lanes on purpose.
    target_compile_options(skywave_kernels PRIVATE
                           $<$<CXX_COMPILER_ID:GNU>:-Wno-uninitialized;-Wno-maybe-uninitialized>)
  endif()
  string(APPEND disabled_targets "|(1LL<<11)|(1LL<<7)|(1LL<<6)|(1LL<<4)")
  target_compile_definitions(skywave_kernels PUBLIC HWY_BASELINE_TARGETS=HWY_${lowest_target})
endif()
target_compile_definitions(skywave_kernels PUBLIC "HWY_DISABLED_TARGETS=(${disabled_targets})")
