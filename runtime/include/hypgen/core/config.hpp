// SPDX-License-Identifier: Apache-2.0
// The compiler's properties that other headers use.
#pragma once

/// Marks functions that host and device code share; nvcc compiles them for both.
#if defined(__CUDACC__)
#define HYPGEN_FN __host__ __device__ inline
#else
#define HYPGEN_FN inline
#endif
