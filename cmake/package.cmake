# Lets `cpack` make Debian packages of the components of cmake/install.cmake, with names and relations
# as Debian's policy wants them. `cmake --workflow --preset package` builds them.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "Skywave")
set(CPACK_PACKAGE_CONTACT "${SKYWAVE_MAINTAINER}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
# Dependencies are those of the libraries that the files are linked with.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENTS_ALL)

# skywave_package(COMPONENT PACKAGE SECTION SUMMARY DESCRIPTION): a package of a component
macro(skywave_package component package section summary description)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${summary}\n${description}")
  install(FILES cmake/debian_copyright RENAME copyright COMPONENT ${component}
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package})
endmacro()

skywave_package(program skywave graphics "wavefront renderer for scenes lit by light probes"
"Skywave is a path tracer for multicore processors. It lights scenes (pbrt, OBJ,
glTF, PLY) by illumination maps (OpenEXR, Radiance HDR, PFM), traces rays in
batches by SIMD kernels and Embree, and compares ways of sampling lights.")

get_target_property(soversion skywave_shared SOVERSION)
skywave_package(library libskywave${soversion} libs "wavefront renderer - shared library"
"Renders scenes lit by illumination maps from within other programs. This
package is for programs that were linked with it.")
# Packages that are linked with the library, ours too, learn their dependency from this.
set(CPACK_DEBIAN_LIBRARY_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR})

skywave_package(development libskywave-dev libdevel "wavefront renderer - development files"
"Renders scenes lit by illumination maps from within other programs. This
package has the header, the files for CMake and pkg-config, and examples.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "libskywave${soversion} (= ${PROJECT_VERSION})")

if(TARGET skywave_python AND NOT SKBUILD)
  skywave_package(python python3-skywave python "wavefront renderer - Python package"
"Renders scenes of files or NumPy arrays, lit by illumination maps, to NumPy
arrays.")
  # An extension module is for one version of Python.
  math(EXPR next_minor "${Python3_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
      "python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next_minor}), python3-numpy"
      "libskywave${soversion} (= ${PROJECT_VERSION})")
  list(JOIN CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS ", " CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS)
endif()

include(CPack)
