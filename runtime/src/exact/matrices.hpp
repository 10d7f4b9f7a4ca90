// SPDX-License-Identifier: Apache-2.0
// What an enumeration has found, and the matrices that it makes of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hypgen/exact/exact_model.hpp"
#include "hypgen/exact/outcome_model.hpp"
#include "row_table.hpp"

namespace hypgen::exact {

// One outcome of a state and an action; observation and state by the numbers under which they were found.
struct Entry {
  double probability;
  int observation;
  int next;
};

// The outcomes of an action, state after state.
struct FoundAction {
  std::vector<Entry> entries;
  std::vector<std::size_t> begin = {0};  // of each state's entries
  std::vector<double> reward;            // of each state
};

struct Found {
  explicit Found(const OutcomeModel& model)
      : states(static_cast<std::size_t>(model.state_words()) + 1),
        keys(static_cast<std::size_t>(model.key_words())),
        actions(static_cast<std::size_t>(model.actions())) {}

  RowTable<std::uint32_t> states;  // the model's words, then the steps taken: 0 without a horizon
  RowTable<std::uint64_t> keys;
  std::vector<FoundAction> actions;
  std::vector<Entry> starts;  // observation 0
};

// Numbers states by class and observations by key. Takes `found` apart, to need little memory.
void make_matrices(const OutcomeModel& model, Found& found, ExactModel& result);

}  // namespace hypgen::exact
