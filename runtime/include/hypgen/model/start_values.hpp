// SPDX-License-Identifier: Apache-2.0
// The start of an episode some of whose values are given, whatever the model says.
#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "hypgen/core/config.hpp"
#include "hypgen/math/float_bits.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

// Empty: nothing is given. Otherwise both have an entry for each value of export_state.
struct StartValues {
  std::vector<std::int32_t> values;
  std::vector<std::uint8_t> given;  // 1: the value counts
};

// The draws of such a start; it must outlive them. A value that is not given draws the words that it always does.
class StartDraws : public PhiloxDraws {
 public:
  StartDraws(StreamKey key, std::uint32_t scenario, const StartValues& start)
      : PhiloxDraws(key, scenario, 0),
        values_(start.values.data()),
        given_(start.given.empty() ? nullptr : start.given.data()) {}

  // The given value at a place of export_state; null where none is.
  HYPGEN_FN const std::int32_t* given(std::int32_t place) const {
    return given_ != nullptr && given_[place] != 0 ? values_ + place : nullptr;
  }

 private:
  const std::int32_t* values_;
  const std::uint8_t* given_;
};

template <class D, class = void>
inline constexpr bool kGivesValues = false;
template <class D>
inline constexpr bool kGivesValues<D, std::void_t<decltype(&D::given)>> = true;

// What a model's init stores at a place of export_state: `drawn`, unless the draw source gives another value.
// What is drawn after it may read it.
template <class T, class D>
HYPGEN_FN T first_value([[maybe_unused]] const D& draws, [[maybe_unused]] std::int32_t place, T drawn) {
  if constexpr (kGivesValues<D>) {
    const std::int32_t* const value = draws.given(place);
    if (value == nullptr) return drawn;
    if constexpr (std::is_same_v<T, float>) return math::from_bits(static_cast<std::uint32_t>(*value));
    return static_cast<T>(*value);
  }
  return drawn;
}

}  // namespace hypgen
