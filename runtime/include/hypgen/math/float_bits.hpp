// SPDX-License-Identifier: Apache-2.0
// Floats and their bits.
#pragma once

#include <cstdint>
#include <cstring>
#include <limits>

#include "hypgen/core/config.hpp"

namespace hypgen::math {

static_assert(std::numeric_limits<float>::is_iec559 && std::numeric_limits<double>::is_iec559);

HYPGEN_FN std::uint32_t to_bits(float x) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  return bits;
}

HYPGEN_FN std::uint64_t to_bits(double x) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  return bits;
}

HYPGEN_FN float from_bits(std::uint32_t bits) {
  float x = 0.0F;
  std::memcpy(&x, &bits, sizeof x);
  return x;
}

HYPGEN_FN double from_bits(std::uint64_t bits) {
  double x = 0.0;
  std::memcpy(&x, &bits, sizeof x);
  return x;
}

/// The bits of a number for comparison: every NaN gives the same ones.
HYPGEN_FN std::uint32_t canonical_bits(float x) { return x != x ? 0x7FC00000U : to_bits(x); }
HYPGEN_FN std::uint64_t canonical_bits(double x) { return x != x ? 0x7FF8000000000000U : to_bits(x); }

}  // namespace hypgen::math
