// The header of Embree 3 or Embree 4, whichever the program is built with, and the flag of scenes
// in which calls bring filters of their own. Calls that build are the same in both; those that
// trace rays are in wavefront/rays/embree_rays.h.
#pragma once

#if SKYWAVE_EMBREE == 4
#include <embree4/rtcore.h>
namespace skywave {
inline constexpr RTCSceneFlags kFiltersOfCalls = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
}
#else
#include <embree3/rtcore.h>
namespace skywave {
inline constexpr RTCSceneFlags kFiltersOfCalls = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
}
#endif
