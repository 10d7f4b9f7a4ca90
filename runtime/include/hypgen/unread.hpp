// Fixed state that nothing has read yet.
//
// What a particle filter learns about a map of which it sees a few cells at a time it learns by killing
// particles, and survivors are copies of each other, in cells too that none of them has ever looked at. But a
// value that was drawn on its own and that no transition, density or other initial value has read has the
// distribution that it had at first, whatever was observed. So copies draw such values anew: as if each value
// were drawn when it is read, of which this is the bookkeeping.
#pragma once

#include <cstdint>
#include <cstring>
#include <type_traits>

#include "hypgen/bits.hpp"
#include "hypgen/philox.hpp"

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

}  // namespace bits

// What a model offers for this, if it does: `M::Tracking`, the same model with a `Fixed` of TrackedWords, and
// `M::is_redrawn(site)`: whether what is drawn there is a fixed hidden variable's, entry by entry.
template <class M, class = void>
struct Tracked {
  static constexpr bool kAny = false;
  using Model = M;
};
template <class M>
struct Tracked<M, std::void_t<typename M::Tracking>> {
  static constexpr bool kAny = true;
  using Model = typename M::Tracking;
};

// The draws of a particle's initial values, but for those that may be made anew.
template <class M>
class RedrawnDraws {
 public:
  RedrawnDraws(const PhiloxDraws& kept, const PhiloxDraws& fresh) : kept_(kept), fresh_(fresh) {}

  std::uint32_t word(std::uint32_t site, std::uint32_t index) {
    return M::is_redrawn(site) ? fresh_.word(site, index) : kept_.word(site, index);
  }

 private:
  PhiloxDraws kept_;
  PhiloxDraws fresh_;
};

}  // namespace hypgen
