// SPDX-License-Identifier: Apache-2.0
// A marginal of the belief as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <utility>

#include "hypgen/solver/step_details.hpp"

namespace hypgen {

inline nlohmann::ordered_json json_of(const Marginal& marginal) {
  if (marginal.is_float)
    return {{"variable", marginal.name}, {"mean", marginal.mean}, {"deviation", marginal.deviation}};
  nlohmann::ordered_json values = nlohmann::ordered_json::array();
  for (const auto& [name, probability] : marginal.values)
    values.push_back({{"value", name}, {"probability", probability}});
  return {{"variable", marginal.name}, {"values", std::move(values)}};
}

}  // namespace hypgen
