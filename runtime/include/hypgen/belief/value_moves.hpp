// SPDX-License-Identifier: Apache-2.0
// Moves of hidden values that never change once the episode has started.
//
// Where all hidden state is like that, a particle is a point, and what was seen weighs the point alone. So a move
// changes a value or two and needs no random words of the past. Words would not do: a ship is put where the
// ships before it leave room, so another word for the first one moves all of them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <type_traits>

#include "hypgen/random/philox.hpp"

namespace hypgen {

// Whether M has values that move (model/model.hpp).
template <class M, class = void>
struct MovesValues : std::false_type {};
template <class M>
struct MovesValues<M, std::void_t<decltype(M::kHiddenValues)>> : std::true_type {};

// Proposes other values. Every change is as likely as its reverse.
template <class M>
class ValueMove {
 public:
  static constexpr std::uint32_t kWords = 7;  // that a move draws

  // `first` is the index of the move's own words.
  ValueMove(PhiloxDraws& draws, std::uint32_t site, std::uint32_t first)
      : draws_(draws), site_(site), first_(first) {}

  // The shares of the old likelihood and of the old density that the new ones have to exceed.
  double likelihood_share() { return share(0); }
  double density_share() { return share(1); }

  // Changes values of `fixed`. False: none has changed.
  bool propose(typename M::Fixed& fixed) {
    const std::uint32_t kind = own(2) >> 29;  // of 8: 5 one value afresh, 1 a step of one, 2 two values
    const auto one = static_cast<int>(below(own(3), M::kHiddenValues));
    if (kind < 5) return put(fixed, one, below(own(4), size(one)));
    if (kind == 5) {
      const std::uint32_t far = 1 + (below(own(4), size(one)) >> below(own(5), kSizes));
      const std::uint32_t step = (own(2) & 1) != 0 ? far % size(one) : size(one) - far % size(one);
      return put(fixed, one, (value(fixed, one) + step) % size(one));
    }
    const auto other = static_cast<int>(below(own(5), M::kHiddenValues));
    if (kind == 6 && size(one) == size(other)) {
      const std::uint32_t kept = value(fixed, one);
      return put(fixed, one, value(fixed, other)) && put(fixed, other, kept);
    }
    const bool first = put(fixed, one, below(own(4), size(one)));
    return put(fixed, other, below(own(6), size(other))) || first;
  }

 private:
  static constexpr std::uint32_t kSizes = 8;  // of steps: up to all values, 1/2, 1/4, ... of them

  static std::uint32_t size(int entry) { return static_cast<std::uint32_t>(M::hidden_size(entry)); }
  static std::uint32_t value(const typename M::Fixed& fixed, int entry) {
    return static_cast<std::uint32_t>(M::hidden_value(fixed, entry));
  }
  static bool put(typename M::Fixed& fixed, int entry, std::uint32_t to) {
    const bool changes = value(fixed, entry) != to;
    M::put_hidden(fixed, entry, static_cast<std::int32_t>(to));
    return changes;
  }
  static std::uint32_t below(std::uint32_t word, std::uint32_t count) {
    return static_cast<std::uint32_t>((std::uint64_t{word} * count) >> 32);
  }
  double share(std::uint32_t i) { return (static_cast<double>(own(i)) + 0.5) * 0x1p-32; }
  std::uint32_t own(std::uint32_t i) { return draws_.word(site_, first_ + i); }

  PhiloxDraws& draws_;
  std::uint32_t site_, first_;
};

}  // namespace hypgen
