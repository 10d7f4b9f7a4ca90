// SPDX-License-Identifier: Apache-2.0
// The exact belief: Bayes' rule over all states of an enumerated model.
#pragma once

#include <cstdint>

#include "hypgen/exact/exact_model.hpp"
#include "hypgen/model/key.hpp"

namespace hypgen::exact {

class ExactFilter {
 public:
  // The model must outlive the filter.
  explicit ExactFilter(const ExactModel& model) : model_(model) {}

  // Starts an episode given all visible variables; false if none starts so.
  bool init(const std::int32_t* visible);

  // Takes in an action and what was seen after it. False if that cannot happen, unless the episode has ended;
  // the belief then stays as it was.
  bool update(int action, KeyWords key);

  const SparseBelief& belief() const { return belief_; }

  // How likely the last observation was.
  double likelihood() const { return likelihood_; }

  // The probability that a variable (an index into the model's export_state) has a value.
  double marginal(int variable, std::int32_t value) const;

 private:
  const ExactModel& model_;
  SparseBelief belief_;
  double likelihood_ = 1.0;
};

// The number of the observation with this key; -1 if none has it.
int find_observation(const ExactModel& model, KeyWords key);

// Half the sum of all differences: 0 for equal beliefs, 1 for beliefs without a common state.
double total_variation(const SparseBelief& a, const SparseBelief& b);

}  // namespace hypgen::exact
