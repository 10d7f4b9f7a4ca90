// SPDX-License-Identifier: Apache-2.0
// What a state is worth at the least where the episode ends with the search's horizon.
#pragma once

#include <algorithm>
#include <type_traits>
#include <vector>

namespace hypgen {

// Whether the model's type knows the least reward of a step.
template <class M, class = void>
constexpr bool kHasLeastReward = false;
template <class M>
constexpr bool kHasLeastReward<M, std::void_t<decltype(M::kLeastReward)>> = true;

// What is earned at the least in so many steps, by their number: a sum of the least reward of a step, or of 0
// where that is larger, as an episode may end. Rounded towards less.
template <class M>
std::vector<float> horizon_floors(double discount, int most_steps) {
  double least = 0.0;
  if constexpr (kHasLeastReward<M>) least = std::min(0.0, static_cast<double>(M::kLeastReward));
  std::vector<float> floors;
  double sum = 0.0, power = 1.0;
  for (int t = 0; t <= most_steps; ++t, power *= discount) {
    floors.push_back(static_cast<float>(sum * (1.0 + 1e-6)));
    sum += power * least;
  }
  return floors;
}

}  // namespace hypgen
