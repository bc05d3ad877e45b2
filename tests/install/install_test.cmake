# Installs a build into a folder, moves the folder, and builds and runs an example with what is there:
#   cmake -DBUILD=... -DSOURCE=... -DFOLDER=... -DCOMPILER=... -DGENERATOR=... -P install_test.cmake
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "this failed with ${status}: ${ARGN}")
  endif()
endfunction()

file(REMOVE_RECURSE ${FOLDER})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${FOLDER}/first)
file(RENAME ${FOLDER}/first ${FOLDER}/second)
foreach(file bin/skywave include/skywave/skywave.h share/bash-completion/completions/skywave)
  if(NOT EXISTS ${FOLDER}/second/${file})
    message(FATAL_ERROR "${file} was not installed")
  endif()
endforeach()
run(${CMAKE_COMMAND} -G "${GENERATOR}" -S ${SOURCE}/examples -B ${FOLDER}/examples
    -DCMAKE_PREFIX_PATH=${FOLDER}/second)
run(${CMAKE_COMMAND} --build ${FOLDER}/examples)
run(${FOLDER}/examples/render_mesh ${FOLDER}/mesh.exr)
run(${FOLDER}/second/bin/skywave info gallery)

# The same by pkg-config.
find_program(PKG_CONFIG pkg-config)
file(GLOB_RECURSE module ${FOLDER}/second/lib/skywave.pc)
if(PKG_CONFIG)
  cmake_path(GET module PARENT_PATH modules)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${modules}
                          ${PKG_CONFIG} --cflags --libs skywave
                  OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags)
  run(${COMPILER} -std=c++20 ${SOURCE}/examples/render_mesh.cc -o ${FOLDER}/by_pkg_config ${flags})
endif()
