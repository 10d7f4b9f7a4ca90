// SPDX-License-Identifier: Apache-2.0
// The lanes of a model that this processor has. No unit of lanes includes it: it runs on any processor.
#pragma once

#include <cstring>
#include <vector>

#include "hypgen/lanes/kernel.hpp"

namespace hypgen {

// Whether this processor runs what is compiled for such a kind (cmake/lanes.txt).
inline bool has_lanes(const hypgen_lanes::Kernel& kernel) {
#if defined(__x86_64__)
  const bool narrow = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                      __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
  if (std::strcmp(kernel.name, "avx512") != 0) return narrow;
  return narrow && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512vl");
#else
  static_cast<void>(kernel);
  return false;
#endif
}

// The first that this processor has; null: none.
inline const hypgen_lanes::Kernel* first_lanes(const std::vector<const hypgen_lanes::Kernel*>& kernels) {
  for (const hypgen_lanes::Kernel* const kernel : kernels) {
    if (has_lanes(*kernel)) return kernel;
  }
  return nullptr;
}

}  // namespace hypgen
