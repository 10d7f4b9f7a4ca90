// SPDX-License-Identifier: Apache-2.0
// The compiler's properties that other headers use.
#pragma once

/// Marks functions that host and device code share; nvcc compiles them for both.
#if defined(__CUDACC__)
#define HYPGEN_FN __host__ __device__ inline
#else
#define HYPGEN_FN inline
#endif

/// The same for functions that are hardly ever called, which host compilers keep out of their callers' code.
#if defined(__CUDACC__)
#define HYPGEN_COLD_FN HYPGEN_FN
#else
#define HYPGEN_COLD_FN __attribute__((noinline, cold)) inline
#endif

/// The same for functions that are too large to stand in each of their callers, for which host compilers make one copy.
#if defined(__CUDACC__)
#define HYPGEN_LARGE_FN HYPGEN_FN
#else
#define HYPGEN_LARGE_FN __attribute__((noinline)) inline
#endif

/// Whether `condition`, which hardly ever holds, does.
#define HYPGEN_RARELY(condition) __builtin_expect(static_cast<bool>(condition), false)
