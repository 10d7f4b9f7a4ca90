// SPDX-License-Identifier: Apache-2.0
// The first decisions, for people and programs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hypgen/exact/exact_instance.hpp"
#include "hypgen/exact/exact_model.hpp"
#include "hypgen/exact/first_actions.hpp"

namespace hypgen::exact {

// First decisions with the model's names. `starts` counts all ways to start, also those that were left out.
struct NamedDecision {
  double probability = 1.0;
  std::string seen;    // what tells this start from others; empty if nothing does
  std::string action;  // "none" where nothing is legal
  FirstDecision decision;
};
std::vector<NamedDecision> named_decisions(const ExactDescriptor& descriptor, const ExactModel& model,
                                           const std::vector<FirstDecision>& decisions);

// The rows of a table: the best actions after the likeliest starts, and what each action is worth after the
// first of them.
std::string first_rows(const ModelDescriptor& model, const std::vector<NamedDecision>& decisions,
                       std::size_t starts);

// An array with an object for each decision.
nlohmann::ordered_json first_json(const ModelDescriptor& model, const std::vector<NamedDecision>& decisions);

}  // namespace hypgen::exact
