// SPDX-License-Identifier: Apache-2.0
#include "hypgen/solver/step_details.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "hypgen/math/float_bits.hpp"

namespace hypgen {

namespace {

void take_float(const Belief& belief, int variable, Marginal& marginal) {
  std::vector<std::pair<double, double>> weighted;
  double total = 0.0, sum = 0.0, squares = 0.0;
  belief.each_value(variable, [&](std::int32_t value, double weight) {
    weighted.emplace_back(math::from_bits(static_cast<std::uint32_t>(value)), weight);
    total += weight;
    sum += weight * weighted.back().first;
  });
  marginal.mean = sum / total;
  for (const auto& [value, weight] : weighted)
    squares += weight * (value - marginal.mean) * (value - marginal.mean);
  marginal.deviation = std::sqrt(squares / total);
}

void take_values(const ModelDescriptor& model, const Belief& belief, int variable, int number,
                 std::size_t most, Marginal& marginal) {
  std::map<std::int32_t, double> weights;
  belief.each_value(variable, [&](std::int32_t value, double weight) {
    if (weight > 0.0) weights[value] += weight;
  });
  std::vector<std::pair<std::int32_t, double>> likely(weights.begin(), weights.end());
  std::stable_sort(likely.begin(), likely.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  likely.resize(std::min(likely.size(), most));
  for (const auto& [value, weight] : likely) {
    marginal.values.emplace_back(value_name(model, number, value), weight);
  }
}

}  // namespace

std::string entry_name(const ModelDescriptor& model, const HiddenVariable& variable, int i) {
  const auto flat = static_cast<std::size_t>(variable.first + i);
  if (flat < model.variable_names.size()) return model.variable_names[flat];
  return variable.count == 1 ? variable.name : variable.name + "[" + std::to_string(i) + "]";
}

std::string value_name(const ModelDescriptor& model, int variable, std::int32_t value) {
  return model.hidden_value_name ? model.hidden_value_name(variable, value) : std::to_string(value);
}

std::vector<Marginal> marginals(const ModelDescriptor& model, const Belief& belief, std::size_t most,
                                std::size_t most_values, std::size_t& left_out) {
  std::vector<Marginal> found;
  left_out = 0;
  for (std::size_t number = 0; number < model.hidden_variables.size(); ++number) {
    const HiddenVariable& variable = model.hidden_variables[number];
    for (int i = 0; i < variable.count; ++i) {
      if (found.size() == most) {
        left_out += static_cast<std::size_t>(variable.count - i);
        break;
      }
      Marginal& marginal = found.emplace_back();
      marginal.name = entry_name(model, variable, i);
      marginal.is_float = variable.is_float;
      if (variable.is_float) {
        take_float(belief, variable.first + i, marginal);
      } else {
        take_values(model, belief, variable.first + i, static_cast<int>(number), most_values, marginal);
      }
    }
  }
  return found;
}

StepDetails step_details(const ModelDescriptor& model, const Belief& belief, Planner& planner,
                         const Decision& decision) {
  StepDetails details;
  if (belief.knows_hidden()) {
    details.marginals = marginals(model, belief, StepDetails::kMostMarginals, StepDetails::kMostValues,
                                  details.marginals_left_out);
  }
  if (!decision.keeps_tree) return details;
  details.root = planner.root_actions();
  const auto key = [&](const RootAction& one) {
    return std::make_tuple(one.action == decision.action, one.visits, one.upper, -one.action);
  };
  std::sort(details.root.begin(), details.root.end(),
            [&](const RootAction& a, const RootAction& b) { return key(a) > key(b); });
  const std::size_t found = details.root.size();
  details.root.resize(std::min(found, StepDetails::kMostActions));
  details.root_left_out = found - details.root.size();
  return details;
}

}  // namespace hypgen
