// Bit fields in the words of a packed state.
#pragma once

#include <cstdint>

#include "hypgen/config.hpp"

namespace hypgen::bits {

/// The `width` lowest bits set; 1 <= width <= 32.
HYPGEN_FN constexpr std::uint32_t mask(std::uint32_t width) { return ~std::uint32_t{0} >> (32 - width); }

/// The field of `width` bits that starts at bit `shift`.
HYPGEN_FN constexpr std::uint32_t get(std::uint32_t word, std::uint32_t shift, std::uint32_t width) {
  return (word >> shift) & mask(width);
}

/// `word` with that field replaced; `field` has no bits beyond it.
HYPGEN_FN constexpr std::uint32_t put(std::uint32_t word, std::uint32_t shift, std::uint32_t width,
                                      std::uint32_t field) {
  return (word & ~(mask(width) << shift)) | (field << shift);
}

}  // namespace hypgen::bits
