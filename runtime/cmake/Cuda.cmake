# SPDX-License-Identifier: Apache-2.0
# Compiles a model for GPUs too. nvcc is called directly: CMake's own test of the CUDA compiler links a
# program, which fails with the toolkit's wheels, whose libraries lie in lib and not in lib64.
set(HYPGEN_CUDA_ARCHITECTURES "75;80;90" CACHE STRING
  "GPUs to compile for, ascending (90: compute capability 9.0); newer ones use the last")
if(CMAKE_CUDA_COMPILER)
  set(HYPGEN_NVCC "${CMAKE_CUDA_COMPILER}")
elseif(DEFINED ENV{CUDACXX})
  set(HYPGEN_NVCC "$ENV{CUDACXX}")
endif()
set(HYPGEN_NVCC "${HYPGEN_NVCC}" CACHE FILEPATH "The CUDA compiler, 12.4 or newer")

# The CUDA compiler, its version checked, and its static runtime library.
function(hypgen_find_nvcc)
  if(NOT HYPGEN_NVCC)
    unset(HYPGEN_NVCC CACHE)
    find_program(HYPGEN_NVCC nvcc
      HINTS $ENV{CUDA_HOME} $ENV{CUDA_PATH} PATHS /usr/local/cuda PATH_SUFFIXES bin)
  endif()
  set(version "")
  if(HYPGEN_NVCC)
    execute_process(COMMAND "${HYPGEN_NVCC}" --version OUTPUT_VARIABLE text ERROR_QUIET)
    string(REGEX MATCH "release ([0-9.]+)" release "${text}")
    set(version "${CMAKE_MATCH_1}")
  endif()
  if(NOT version OR version VERSION_LESS 12.4)
    message(FATAL_ERROR "No nvcc 12.4 or newer (found: '${HYPGEN_NVCC}' ${version}). Set HYPGEN_NVCC to "
      "one, or HYPGEN_CUDA=OFF to compile for the CPU alone.")
  endif()
  get_filename_component(bin "${HYPGEN_NVCC}" REALPATH)
  get_filename_component(bin "${bin}" DIRECTORY)
  find_library(HYPGEN_CUDART NAMES libcudart_static.a
    HINTS "${bin}/.." PATH_SUFFIXES lib64 lib "targets/${CMAKE_HOST_SYSTEM_PROCESSOR}-linux/lib")
  if(NOT HYPGEN_CUDART)
    message(FATAL_ERROR "No libcudart_static.a with '${HYPGEN_NVCC}'. Set HYPGEN_CUDART to it.")
  endif()
endfunction()

include("${CMAKE_CURRENT_LIST_DIR}/CompileOptions.cmake")

# Adds sources, for nvcc, to a target. The host compiler gets the flags of hypgen_compile_options.
function(hypgen_device_units target)
  hypgen_find_nvcc()
  file(STRINGS "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/nvcc_flags.txt" flags)
  foreach(architecture IN LISTS HYPGEN_CUDA_ARCHITECTURES)
    list(APPEND flags "-gencode=arch=compute_${architecture},code=sm_${architecture}")
  endforeach()
  list(GET HYPGEN_CUDA_ARCHITECTURES -1 newest)
  list(APPEND flags "-gencode=arch=compute_${newest},code=compute_${newest}")
  if(NOT DEFINED ENV{NVCC_CCBIN})
    list(APPEND flags -ccbin "${CMAKE_CXX_COMPILER}")
  endif()
  hypgen_host_flags(host_flags)
  list(APPEND host_flags -O3 -fPIC)
  if(HYPGEN_NATIVE)
    list(APPEND host_flags -march=native)
  endif()
  foreach(flag IN LISTS host_flags)
    list(APPEND flags "-Xcompiler=${flag}")
  endforeach()
  get_filename_component(here "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/../include" ABSOLUTE)
  foreach(source IN LISTS ARGN)
    get_filename_component(input "${source}" ABSOLUTE)
    get_filename_component(name "${source}" NAME)
    set(object "${CMAKE_CURRENT_BINARY_DIR}/${name}.o")
    add_custom_command(OUTPUT "${object}"
      COMMAND "${HYPGEN_NVCC}" ${flags} "-I${here}" -MD -MF "${object}.d" -c "${input}" -o "${object}"
      DEPENDS "${input}" DEPFILE "${object}.d" VERBATIM
      COMMENT "Building CUDA object ${source}")
    target_sources(${target} PRIVATE "${object}")
  endforeach()
  target_compile_definitions(${target} PRIVATE HYPGEN_CUDA)
  target_link_libraries(${target} PRIVATE "${HYPGEN_CUDART}" ${CMAKE_DL_LIBS} rt)
endfunction()
