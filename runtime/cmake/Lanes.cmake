# SPDX-License-Identifier: Apache-2.0
# A model's lanes: one source, compiled for several kinds of processors. A program takes the widest one that its
# processor has.

include(CheckCXXCompilerFlag)

# Compiles `source` into `target` for each line of lanes.txt that the compiler knows, with another name for the
# namespace hypgen each time: no other code may call what these flags have made.
function(hypgen_lanes target source)
  if(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
    return()
  endif()
  file(STRINGS "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/lanes.txt" kinds)
  foreach(kind IN LISTS kinds)
    string(REPLACE " " ";" kind "${kind}")
    list(GET kind 0 name)
    list(GET kind 1 architecture)
    check_cxx_compiler_flag("-march=${architecture}" HYPGEN_KNOWS_${name})
    if(NOT HYPGEN_KNOWS_${name})
      continue()
    endif()
    add_library(${target}_${name} OBJECT ${source})
    target_include_directories(${target}_${name} PRIVATE $<TARGET_PROPERTY:${target},INCLUDE_DIRECTORIES>)
    hypgen_compile_options(${target}_${name})
    target_compile_options(${target}_${name} PRIVATE
      "-march=${architecture}" "-Dhypgen=hypgen_${name}" "-DHYPGEN_LANES=${name}" -Wno-psabi
      $<$<CXX_COMPILER_ID:GNU>:-Wno-uninitialized -Wno-maybe-uninitialized>)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:${target}_${name}>)
    target_compile_definitions(${target} PRIVATE HYPGEN_HAS_${name})
  endforeach()
endfunction()
