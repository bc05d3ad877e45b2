# Says what `cmake --install` puts where, in three components: `program`, `library` (for programs that
# were linked with Skywave) and `development` (for linking with it).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS skywave RUNTIME COMPONENT program)

# Manual pages and completions are printed by the program, from its table of options. The program
# alone (the target skywave) does not wait for them.
set(documents ${CMAKE_BINARY_DIR}/documents)
add_custom_command(OUTPUT ${documents}/made
  COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:skywave> -DOUTPUT=${documents}
          -P ${CMAKE_SOURCE_DIR}/cmake/documents.cmake
  DEPENDS skywave ${CMAKE_SOURCE_DIR}/cmake/documents.cmake
  COMMENT "Printing manual pages and completions" VERBATIM)
add_custom_target(skywave_documents ALL DEPENDS ${documents}/made)
install(DIRECTORY ${documents}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT program)
install(FILES ${documents}/skywave.bash RENAME skywave COMPONENT program
        DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
# Debian's zsh looks for the completions of packages in a folder of its own.
install(CODE "set(documents \"${documents}\")" COMPONENT program)
install(CODE [[
  set(folder site-functions)
  if(CMAKE_INSTALL_PREFIX MATCHES "/usr/?$" AND EXISTS /etc/debian_version)
    set(folder vendor-completions)
  endif()
  file(INSTALL ${documents}/_skywave DESTINATION ${CMAKE_INSTALL_PREFIX}/share/zsh/${folder})
]] COMPONENT program)

install(TARGETS skywave_shared EXPORT skywave
        LIBRARY COMPONENT library NAMELINK_COMPONENT development)
install(FILES api/skywave.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/skywave COMPONENT development)

# find_package(skywave) gives the target skywave::skywave.
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/skywave)
install(EXPORT skywave NAMESPACE skywave:: FILE skywaveConfig.cmake DESTINATION ${package}
        COMPONENT development)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/skywaveConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/skywaveConfigVersion.cmake DESTINATION ${package}
        COMPONENT development)

# The file gives the prefix relative to its own place, so that an installation can be moved.
cmake_path(RELATIVE_PATH CMAKE_INSTALL_FULL_LIBDIR BASE_DIRECTORY ${CMAKE_INSTALL_PREFIX}
           OUTPUT_VARIABLE libraries)
string(REGEX REPLACE "[^/]+" ".." up ${libraries})
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/skywave.pc @ONLY CONTENT [[
prefix=${pcfiledir}/../@up@
Name: skywave
Description: @PROJECT_DESCRIPTION@
URL: @PROJECT_HOMEPAGE_URL@
Version: @PROJECT_VERSION@
Cflags: -I${prefix}/@CMAKE_INSTALL_INCLUDEDIR@
Libs: -L${prefix}/@CMAKE_INSTALL_LIBDIR@ -lskywave
]])
install(FILES ${CMAKE_BINARY_DIR}/skywave.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
        COMPONENT development)
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT development
        USE_SOURCE_PERMISSIONS)
