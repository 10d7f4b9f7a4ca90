# SPDX-License-Identifier: Apache-2.0
# How all of hypgen's C++ is compiled, generated models included.

# Sets `result` to the flags on which equal bits rest: host_flags.txt, which hypgen's own builder reads too.
# Contraction to fused multiply-adds would make results depend on the processor.
function(hypgen_host_flags result)
  set(file "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/host_flags.txt")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${file}")
  file(STRINGS "${file}" flags)
  set(${result} ${flags} PARENT_SCOPE)
endfunction()

function(hypgen_compile_options target)
  target_compile_features(${target} PUBLIC cxx_std_17)
  set_target_properties(${target} PROPERTIES
    CXX_STANDARD 17
    CXX_STANDARD_REQUIRED ON
    CXX_EXTENSIONS OFF
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON
    POSITION_INDEPENDENT_CODE ON)
  hypgen_host_flags(flags)
  target_compile_options(${target} PRIVATE ${flags} -Wall -Wextra -Wconversion
    $<$<BOOL:${HYPGEN_NATIVE}>:-march=native>
    $<$<BOOL:${HYPGEN_WERROR}>:-Werror>)
  # clang++ warns of signs with -Wconversion; g++ does not, and sizes are computed from ints all over.
  target_compile_options(${target} PRIVATE -Wno-sign-conversion)
  # clang++ 17 and newer report that std::stable_sort of libstdc++ 12 calls a function that C++17 deprecates.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:Clang>:-Wno-deprecated-declarations>)
endfunction()
