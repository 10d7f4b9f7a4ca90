// SPDX-License-Identifier: Apache-2.0
// Fixed state that a particle has not read yet, and may draw again.
//
// A robot that maps sees a few cells at a time. A particle filter learns the map by dropping particles. The
// survivors are copies of each other, even in cells that none of them has looked at. But observations depend
// on a particle's random words only through the values that the particle has read. So a copy may draw the
// words of unread values again, if that leaves all read values as they are. This is a step of Metropolis and
// Hastings that proposes from the prior and never changes a likelihood. Where an unread value depends on kept
// values alone, the result is as if particles drew values when they read them.
#pragma once

#include <cstdint>
#include <cstring>
#include <type_traits>

#include "hypgen/model/bits.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

// A word of packed state that notes which of its bits the model has read.
struct TrackedWord {
  std::uint32_t value;
  mutable std::uint32_t read;

  HYPGEN_FN TrackedWord& operator=(std::uint32_t word) {
    value = word;
    return *this;
  }
  HYPGEN_FN operator std::uint32_t() const {
    read = ~std::uint32_t{0};
    return value;
  }
};

namespace bits {

HYPGEN_FN std::uint32_t get(const TrackedWord& word, std::uint32_t shift, std::uint32_t width) {
  word.read |= mask(width) << shift;
  return get(word.value, shift, width);
}

HYPGEN_FN std::uint32_t put(const TrackedWord& word, std::uint32_t shift, std::uint32_t width,
                            std::uint32_t field) {
  return put(word.value, shift, width, field);
}

HYPGEN_FN bool was_read(const TrackedWord& word, std::uint32_t shift, std::uint32_t width) {
  return (word.read & mask(width) << shift) != 0;
}

}  // namespace bits

// The model whose words note reads: `M::Tracking` if M has it (model/model.hpp, Redraw), otherwise M itself.
// `Own` is the data that each particle has besides its state. `word` numbers the random words that may be drawn
// again, those of single values first; -1: not such a word.
template <class M, class = void>
struct Tracked {
  static constexpr bool kAny = false;
  static constexpr int kWords = 0, kSingles = 0;
  using Model = M;
  struct Own {};
  static int word(std::uint32_t, std::uint32_t) { return -1; }
};
template <class M>
struct Tracked<M, std::void_t<typename M::Tracking>> {
  static constexpr bool kAny = true;
  static constexpr int kWords = M::kRedrawnWords, kSingles = M::kRedrawnSingles;
  using Model = typename M::Tracking;
  struct Own {
    typename Model::State start;  // its initial one
  };
  static int word(std::uint32_t site, std::uint32_t index) { return M::redrawn_word(site, index); }
};

}  // namespace hypgen
