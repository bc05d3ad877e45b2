# Writes GitRevision (bench/measure/revision.h) to OUTPUT for the sources in SOURCE; leaves the file alone
# where nothing has changed:  cmake -DSOURCE=... -DOUTPUT=... -P cmake/revision.cmake
set(revision "")
find_program(GIT git)
if(GIT)
  # A copy of the sources inside of somebody else's repository has no revision.
  execute_process(COMMAND ${GIT} rev-parse --show-prefix WORKING_DIRECTORY ${SOURCE}
                  OUTPUT_VARIABLE prefix OUTPUT_STRIP_TRAILING_WHITESPACE
                  RESULT_VARIABLE failed ERROR_QUIET)
  if(NOT failed AND prefix STREQUAL "")
    execute_process(COMMAND ${GIT} describe --always --exclude=* --abbrev=40 --dirty
                    WORKING_DIRECTORY ${SOURCE} OUTPUT_VARIABLE revision
                    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  endif()
endif()
if(revision STREQUAL "")
  set(revision unknown)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT [[
#include "bench/measure/revision.h"

std::string skywave::GitRevision() { return "@revision@"; }
]])
