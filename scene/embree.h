// The header of Embree 3 or Embree 4, whichever the program is built with. Calls that build are the
// same in both; those that trace rays are in wavefront/rays/embree_rays.h.
#pragma once

#if __has_include(<embree4/rtcore.h>) && SKYWAVE_EMBREE != 3
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
