// SPDX-License-Identifier: Apache-2.0
// Draws of 63 bits, for probabilities that one 32-bit word does not hold.
//
// A mass is a number of 2^-63, as a whole has 2^63. A draw is below a mass by its word alone, unless the word
// ties with the mass's upper bits: then a second word of the same draw decides. It is made for one draw in 2^32.
#pragma once

#include <cstdint>
#include <utility>

#include "hypgen/core/config.hpp"
#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/random/philox.hpp"
#include "hypgen/random/word_thresholds.hpp"

namespace hypgen::dist {

/// From the index of a draw's word to that of a draw within the draw.
inline constexpr std::uint32_t kNextDraw = std::uint32_t{1} << 24;

/// The mass of all outcomes, and the one from which on a float32's mass is a whole number of words.
inline constexpr std::uint64_t kWhole = std::uint64_t{1} << 63;
inline constexpr std::uint64_t kRare = std::uint64_t{1} << 54;
/// The bits of a mass below a word.
inline constexpr std::uint32_t kLowBits = 31;
inline constexpr std::uint64_t kLow = (std::uint64_t{1} << kLowBits) - 1;

/// The probability of a mass.
HYPGEN_FN double share_of(std::uint64_t mass) {
  return static_cast<double>(mass) * 1.08420217248550443400745280086994171142578125e-19;
}

/// Where a mass that starts at `until` ends: not beyond the whole.
HYPGEN_FN std::uint64_t up_to(std::uint64_t until, std::uint64_t mass) {
  return mass < kWhole - until ? until + mass : kWhole;
}

/// The mass of a float32 probability; with `complement`, what it lacks to 1, precise where it is near 1.
HYPGEN_FN std::uint64_t mass(float p) { return math::mass(p); }
HYPGEN_FN std::uint64_t mass(float p, float complement) {
  return complement < 0.001953125F ? kWhole - math::mass(complement) : math::mass(p);
}

/// Gives the likeliest of a table's masses what the others leave, if the last is rare.
template <int N>
HYPGEN_FN void settle(std::uint64_t (&masses)[N]) {
  if (masses[N - 1] >= kRare) return;
  int likeliest = 0;
  for (int i = 1; i < N; ++i) {
    if (masses[i] > masses[likeliest]) likeliest = i;
  }
  std::uint64_t others = 0;
  for (int i = 0; i < N; ++i) {
    if (i != likeliest) others = up_to(others, masses[i]);
  }
  masses[likeliest] = kWhole - others;
}

/// `pieces` equal parts of what lies from `first` to the whole; those before `larger` have one more.
struct Pieces {
  std::uint64_t first;
  std::uint64_t count;
  std::uint64_t size;
  std::uint64_t larger;

  HYPGEN_FN Pieces(std::uint64_t from, std::uint64_t pieces)
      : first(from), count(pieces), size((kWhole - from) / pieces), larger((kWhole - from) % pieces) {}

  HYPGEN_FN std::uint64_t at(std::uint64_t bits) const {
    const std::uint64_t beyond = bits - first, end = larger * (size + 1);
    return beyond < end ? beyond / (size + 1) : larger + (beyond - end) / size;
  }
  HYPGEN_FN std::uint64_t end(std::uint64_t piece) const {
    return first + (piece + 1) * size + (piece < larger ? piece + 1 : larger);
  }
};

/// The word of a draw, and behind it its second word, made where it is needed.
template <class D>
class FineWord {
 public:
  HYPGEN_FN FineWord(D& draws, std::uint32_t site, std::uint32_t index)
      : draws_(&draws), site_(site), index_(index), word_(draws.word(site, index)) {}

  HYPGEN_FN bool below(std::uint64_t mass) const { return is_below(word_, mass, *this); }

  /// In which of the pieces, from a mass on that the draw is not below, it lies.
  HYPGEN_FN std::uint64_t piece(const Pieces& pieces) const { return piece_at(word_, pieces, *this); }

  HYPGEN_FN std::uint64_t low_bits() const { return second_word(*draws_, site_, index_) >> 1; }

  HYPGEN_FN auto word() const { return word_; }

 private:
  D* draws_;
  std::uint32_t site_;
  std::uint32_t index_;
  decltype(std::declval<D&>().word(0, 0)) word_;
};

/// What `FineWord` asks of a plain word; an interval of words has its own (enumerating_draws.hpp).
template <class D>
HYPGEN_FN bool is_below(std::uint32_t word, std::uint64_t mass, const FineWord<D>& fine) {
  const std::uint64_t high = mass >> kLowBits, low = mass & kLow;
  if (HYPGEN_RARELY(word == high) && low != 0) return fine.low_bits() < low;
  return word < high;
}

template <class D>
HYPGEN_FN std::uint64_t piece_at(std::uint32_t word, const Pieces& pieces, const FineWord<D>& fine) {
  const std::uint64_t least = std::uint64_t{word} << kLowBits;
  const std::uint64_t from = pieces.at(least < pieces.first ? pieces.first : least);
  return from == pieces.at(least | kLow) ? from : pieces.at(least | fine.low_bits());
}

template <class D>
HYPGEN_FN FineWord<D> fine(D& draws, std::uint32_t site, std::uint32_t index) {
  return {draws, site, index};
}

}  // namespace hypgen::dist
