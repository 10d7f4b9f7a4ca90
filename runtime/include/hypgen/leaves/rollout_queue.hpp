// SPDX-License-Identifier: Apache-2.0
// Rollouts that wait to be played side by side.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hypgen/lanes/kernel.hpp"

namespace hypgen {

// Where the rollouts of one depth start, and what each earns.
template <class M>
struct RolloutQueue {
  // The least room, besides that for each action of a scenario: leaves fill lanes several times over.
  static constexpr std::size_t kRoom = 1024;

  explicit RolloutQueue(bool is_used) : room(is_used ? kRoom + M::kActionCount : 0) {
    states.reserve(room);
    histories.reserve(room);
    scenarios.reserve(room);
    numbers.reserve(room);
    earned.resize(room);
  }

  static std::size_t bytes() {
    return (kRoom + M::kActionCount) *
           (sizeof(typename M::State) + sizeof(void*) + 2 * sizeof(std::uint32_t) + sizeof(float));
  }

  void clear() {
    states.clear();
    histories.clear();
    scenarios.clear();
    numbers.clear();
  }

  // `number`: by which it draws.
  std::size_t add(std::uint32_t scenario, const typename M::State& state, const typename M::History& history,
                  std::uint32_t number) {
    states.push_back(state);
    histories.push_back(&history);
    scenarios.push_back(scenario);
    numbers.push_back(number);
    return states.size() - 1;
  }

  // Whether `count` more fit.
  bool has_room(std::size_t count) const { return states.size() + count <= room; }

  std::size_t room;
  std::vector<typename M::State> states;
  std::vector<const void*> histories;
  std::vector<std::uint32_t> scenarios;  // of the search
  std::vector<std::uint32_t> numbers;
  std::vector<float> earned;
};

}  // namespace hypgen
