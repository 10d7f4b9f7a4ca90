// SPDX-License-Identifier: Apache-2.0
// What a step was decided by: the belief's marginals and the root's actions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/model/descriptor.hpp"
#include "hypgen/search/decision.hpp"
#include "hypgen/search/planner.hpp"

namespace hypgen {

// The belief in one hidden variable, or in one entry of it.
struct Marginal {
  std::string name;
  bool is_float = false;
  double mean = 0.0;  // of a float
  double deviation = 0.0;
  std::vector<std::pair<std::string, double>> values{};  // otherwise: the likeliest and their probabilities
};

// The name of entry `i` of a hidden variable, and of a value of hidden_variables[variable].
std::string entry_name(const ModelDescriptor& model, const HiddenVariable& variable, int i);
std::string value_name(const ModelDescriptor& model, int variable, std::int32_t value);

// The belief in the hidden variables, entry by entry in the model's order: the first `most` of them, each with
// its `most_values` likeliest values.
std::vector<Marginal> marginals(const ModelDescriptor& model, const Belief& belief, std::size_t most,
                                std::size_t most_values, std::size_t& left_out);

struct StepDetails {
  static constexpr std::size_t kMostMarginals = 100;
  static constexpr std::size_t kMostValues = 5;
  static constexpr std::size_t kMostActions = 10;

  std::vector<Marginal> marginals;  // in the model's order; none where no belief is kept
  std::size_t marginals_left_out = 0;
  std::vector<RootAction> root;  // the decision's, then those that most trials took; none without a tree
  std::size_t root_left_out = 0;
};

// To be called between the decision and the belief's next update.
StepDetails step_details(const ModelDescriptor& model, const Belief& belief, Planner& planner,
                         const Decision& decision);

}  // namespace hypgen
