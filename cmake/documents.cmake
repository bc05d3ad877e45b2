# Writes manual pages and completions, which PROGRAM prints, to the folder OUTPUT:
#   cmake -DPROGRAM=skywave -DOUTPUT=... -P cmake/documents.cmake
# print(FILE ARGUMENTS...): writes what `skywave options ARGUMENTS` prints
function(print file)
  execute_process(COMMAND ${PROGRAM} options ${ARGN} OUTPUT_FILE ${OUTPUT}/${file}
                  COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${OUTPUT})
file(MAKE_DIRECTORY ${OUTPUT}/man1)
print(skywave.bash --format bash)
print(_skywave --format zsh)
print(man1/skywave.1 --format man)
print(options.json --format json)
file(READ ${OUTPUT}/options.json json)
string(JSON last LENGTH "${json}" commands)
math(EXPR last "${last} - 1")
foreach(i RANGE ${last})
  string(JSON command MEMBER "${json}" commands ${i})
  string(REPLACE " " "-" page ${command})
  print(man1/skywave-${page}.1 --format man --of ${command})
endforeach()
find_program(GZIP gzip)
if(GZIP)  # as distributions have them, and without the time of the build
  file(GLOB pages ${OUTPUT}/man1/*.1)
  execute_process(COMMAND ${GZIP} -9n ${pages} COMMAND_ERROR_IS_FATAL ANY)
endif()
file(TOUCH ${OUTPUT}/made)
