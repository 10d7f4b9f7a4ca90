// SPDX-License-Identifier: Apache-2.0
// Probabilities as numbers of 32-bit words.
#pragma once

#include <cmath>
#include <cstdint>

#include "hypgen/core/config.hpp"

namespace hypgen::dist {

/// The number of words there are.
inline constexpr std::uint64_t kWords = std::uint64_t{1} << 32;

/// The probability of `words` out of all words.
HYPGEN_FN double share(std::uint64_t words) { return static_cast<double>(words) * (1.0 / 4294967296.0); }

/// In which of `pieces` equal pieces of the words from `first` on a word lies.
HYPGEN_FN std::uint64_t piece_of(std::uint32_t word, std::uint64_t first, std::uint64_t pieces) {
  return (word - first) * pieces / (kWords - first);
}

/// A word to start a search for the word's value from.
HYPGEN_FN std::uint32_t typical(std::uint32_t word) { return word; }

/// R(x): the number of words that a cumulative probability takes, rounded to nearest; 0 for NaN.
HYPGEN_FN std::uint64_t words_of(double probability) {
  const double scaled = std::floor(probability * 4294967296.0 + 0.5);
  if (!(scaled > 0.0)) return 0;
  return scaled < 4294967296.0 ? static_cast<std::uint64_t>(scaled) : kWords;
}

}  // namespace hypgen::dist
