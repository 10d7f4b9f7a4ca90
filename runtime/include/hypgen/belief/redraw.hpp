// Fixed state that nothing has read yet.
//
// What a particle filter learns about a map of which it sees a few cells at a time it learns by killing
// particles, and survivors are copies of each other, in cells too that none of them has ever looked at. But
// all that was observed depends on a particle's random words through the values that were read only. So a
// copy may draw the words of other values anew, where that leaves all that was read as it is: a step of
// Metropolis and Hastings that never changes a likelihood and proposes from the prior. Where an unread value
// depends on nothing but what is kept, it is as if values were drawn when they are read.
#pragma once

#include <cstdint>
#include <cstring>
#include <type_traits>

#include "hypgen/model/bits.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

// A word of packed state that notes which of its bits have been read.
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

// What a model offers for this, if it does: `M::Tracking`, the same model with a `Fixed` of TrackedWords;
// `redrawn_word(site, index)`, which of kRedrawnWords random words is drawn there, -1 if none, those of
// single values, kRedrawnSingles, first; `is_word_read(fixed, word)`, whether its value was read.
template <class M, class = void>
struct Tracked {
  static constexpr bool kAny = false;
  using Model = M;
  struct Own {};
};
template <class M>
struct Tracked<M, std::void_t<typename M::Tracking>> {
  static constexpr bool kAny = true;
  using Model = typename M::Tracking;
  struct Own {  // of a particle
    std::uint32_t words[M::kRedrawnWords];
    typename Model::State start;
  };
};

// The draws of a particle's initial values: those of its origin, but for the words that it has of its own.
template <class M>
class OwnDraws {
 public:
  OwnDraws(const PhiloxDraws& origin, const std::uint32_t* words) : origin_(origin), words_(words) {}

  std::uint32_t word(std::uint32_t site, std::uint32_t index) {
    const int own = M::redrawn_word(site, index);
    return own < 0 ? origin_.word(site, index) : words_[own];
  }

 private:
  PhiloxDraws origin_;
  const std::uint32_t* words_;
};

}  // namespace hypgen
