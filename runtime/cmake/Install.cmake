# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` copies, with places relative to the prefix: the package hypgen_runtime, for programs and
# exported projects. Headers below hypgen/ stay here: they are no interface, and exported projects have their own.
set(HYPGEN_PACKAGE lib/cmake/hypgen_runtime)
install(TARGETS hypgen_runtime EXPORT hypgen_runtime-targets ARCHIVE DESTINATION lib COMPONENT hypgen_runtime)
install(EXPORT hypgen_runtime-targets NAMESPACE hypgen:: DESTINATION ${HYPGEN_PACKAGE} COMPONENT hypgen_runtime)
install(FILES include/hypgen.h include/hypgen.hpp DESTINATION include COMPONENT hypgen_runtime)

include(CMakePackageConfigHelpers)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/hypgen_runtime-config-version.cmake"
  COMPATIBILITY SameMajorVersion)
install(FILES cmake/hypgen_runtime-config.cmake "${PROJECT_BINARY_DIR}/hypgen_runtime-config-version.cmake"
  DESTINATION ${HYPGEN_PACKAGE} COMPONENT hypgen_runtime)
foreach(page LICENSE NOTICE) # links in hypgen's own sources
  get_filename_component(page "${page}" REALPATH)
  install(FILES "${page}" DESTINATION share/doc/hypgen_runtime/hypgen COMPONENT hypgen_runtime)
endforeach()
install(FILES "${HYPGEN_JSON_INCLUDE_DIR}/nlohmann/LICENSE" DESTINATION share/doc/hypgen_runtime/nlohmann-json
  COMPONENT hypgen_runtime OPTIONAL)

# hypgen takes these by name for its own programs.
foreach(library hypgen_verify hypgen_exact)
  if(TARGET ${library})
    install(FILES $<TARGET_FILE:${library}> DESTINATION lib COMPONENT ${library} EXCLUDE_FROM_ALL)
  endif()
endforeach()
