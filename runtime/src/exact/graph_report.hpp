// SPDX-License-Identifier: Apache-2.0
// A policy's graph, for people and programs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "hypgen/exact/exact_instance.hpp"
#include "hypgen/exact/exact_model.hpp"
#include "hypgen/exact/policy_graph.hpp"

namespace hypgen::exact {

// Lines: for each node its action, and what leads where.
std::string graph_text(const ExactDescriptor& descriptor, const ExactModel& model, const PolicyGraph& graph);

nlohmann::ordered_json graph_json(const ExactDescriptor& descriptor, const ExactModel& model,
                                  const PolicyGraph& graph);

}  // namespace hypgen::exact
