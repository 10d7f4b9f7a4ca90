// SPDX-License-Identifier: Apache-2.0
// Bit fields in the words of a packed state.
#pragma once

#include <cstdint>

#include "hypgen/core/config.hpp"

// g++ before 14 may compile `bit == value`, where the bit's position varies, as `bit != 0` (GCC's PR
// target/111408): 12.2 at -O1 did so to densities of what was seen, for fields of one bit and for the lowest
// bit of wider ones. It cannot where it does not see that a bit is taken.
#if defined(__GNUC__) && __GNUC__ < 14 && !defined(__clang__) && !defined(__CUDA_ARCH__) && \
    (defined(__x86_64__) || defined(__i386__))
#define HYPGEN_HIDES_BIT_TESTS
#endif

namespace hypgen::bits {

/// The `width` lowest bits set; 1 <= width <= 32.
HYPGEN_FN constexpr std::uint32_t mask(std::uint32_t width) { return ~std::uint32_t{0} >> (32 - width); }

/// The field of `width` bits that starts at bit `shift`.
HYPGEN_FN std::uint32_t get(std::uint32_t word, std::uint32_t shift, std::uint32_t width) {
#if defined(HYPGEN_HIDES_BIT_TESTS)
  if (!__builtin_constant_p(shift)) {
    if (width == 1) {
      bool set;
      asm("bt{l\t%2, %1|\t%1, %2}" : "=@ccc"(set) : "r"(word), "r"(shift));
      return set ? 1 : 0;
    }
    word >>= shift;
    asm("" : "+r"(word));
    return word & mask(width);
  }
#endif
  return (word >> shift) & mask(width);
}

/// `word` with that field replaced; `field` has no bits beyond it.
HYPGEN_FN constexpr std::uint32_t put(std::uint32_t word, std::uint32_t shift, std::uint32_t width,
                                      std::uint32_t field) {
  return (word & ~(mask(width) << shift)) | (field << shift);
}

}  // namespace hypgen::bits
