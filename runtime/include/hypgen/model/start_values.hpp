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

// Where such values lie: both arrays have an entry for each value of export_state. Null: nothing is given.
struct StartView {
  const std::int32_t* values = nullptr;
  const std::uint8_t* given = nullptr;  // 1: the value counts
};

// Empty: nothing is given.
struct StartValues {
  std::vector<std::int32_t> values;
  std::vector<std::uint8_t> given;

  StartView view() const { return given.empty() ? StartView{} : StartView{values.data(), given.data()}; }
};

// The draws of such a start, whose arrays must outlive them. A value that is not given draws the words that it
// always does.
class StartDraws : public PhiloxDraws {
 public:
  HYPGEN_FN StartDraws(StreamKey key, std::uint32_t scenario, StartView start)
      : PhiloxDraws(key, scenario, 0), start_(start) {}

  // The given value at a place of export_state; null where none is.
  HYPGEN_FN const std::int32_t* given(std::int32_t place) const {
    return start_.given != nullptr && start_.given[place] != 0 ? start_.values + place : nullptr;
  }

 private:
  StartView start_;
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
