// SPDX-License-Identifier: Apache-2.0
// The states of a model as `hypgen export` numbers them, for files that belong to an exported model.
//
// There a state whose observation depends on the state before is split, a copy for each law of what is seen
// (hypgen.dsl.foreign.enumerated.split_states says how), and a last state follows the end of an episode.
#pragma once

#include <cstddef>
#include <vector>

#include "hypgen/exact/exact_model.hpp"

namespace hypgen::exact {

struct ExportedStates {
  explicit ExportedStates(const ExactModel& model);

  std::size_t size() const { return state.size() + (ended ? 1 : 0); }

  std::vector<int> state;  // of each copy; ascending
  bool ended = false;      // one more state follows, in which the episode is over
};

}  // namespace hypgen::exact
