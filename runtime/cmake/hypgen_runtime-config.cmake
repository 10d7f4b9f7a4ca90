# SPDX-License-Identifier: Apache-2.0
# find_package(hypgen_runtime) gives hypgen::runtime: hypgen.h, hypgen.hpp, and what static libraries of all models share.
include(CMakeFindDependencyMacro)
find_dependency(Threads)
include("${CMAKE_CURRENT_LIST_DIR}/hypgen_runtime-targets.cmake")
