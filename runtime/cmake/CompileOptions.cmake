# How all of hypgen's C++ is compiled, generated models included.
function(hypgen_compile_options target)
  target_compile_features(${target} PUBLIC cxx_std_17)
  set_target_properties(${target} PROPERTIES
    CXX_EXTENSIONS OFF
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON
    POSITION_INDEPENDENT_CODE ON)
  # Contraction would make results depend on the processor.
  target_compile_options(${target} PRIVATE -ffp-contract=off -Wall -Wextra -Wconversion
    $<$<CONFIG:Release>:-O3>
    $<$<BOOL:${HYPGEN_NATIVE}>:-march=native>
    $<$<BOOL:${HYPGEN_WERROR}>:-Werror>)
  # clang++ warns of signs with -Wconversion; g++ does not, and sizes are computed from ints all over.
  target_compile_options(${target} PRIVATE -Wno-sign-conversion)
endfunction()
