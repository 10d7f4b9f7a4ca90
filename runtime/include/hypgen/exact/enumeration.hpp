// SPDX-License-Identifier: Apache-2.0
// From a model to its matrices: all states that can be reached, breadth first, and all that can happen there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "hypgen/exact/exact_model.hpp"
#include "hypgen/exact/outcome_model.hpp"

namespace hypgen::exact {

struct EnumerationLimits {
  std::size_t states = 1000000;
  std::size_t outcomes = 100000000;
  std::size_t bytes = std::size_t{4} << 30;
};

// How far an enumeration has come.
struct EnumerationCounts {
  std::size_t expanded = 0;  // states of which all outcomes are known
  std::size_t states = 0;
  std::size_t outcomes = 0;  // with another state, action, observation or next state each
  std::size_t bytes = 0;
};

// False ends the enumeration.
using EnumerationProgress = std::function<bool(const EnumerationCounts&)>;

// Where a reward is no number, or beyond the range of rewards: in a step with the action, from a state whose
// flattened variables have the values.
struct BrokenStep {
  int action = -1;  // -1: there is none
  std::vector<std::int32_t> values;
};

struct Enumeration {
  ExactModel model;      // only without a problem
  std::string problem;   // why there is no model, and what to do
  bool stopped = false;  // by `progress`
  BrokenStep broken;     // what the problem is about
};

// Enumerates a model with the given discount; `horizon` 0 means none.
Enumeration enumerate(const OutcomeModel& model, double discount, int horizon,
                      const EnumerationLimits& limits, const EnumerationProgress& progress);

}  // namespace hypgen::exact
