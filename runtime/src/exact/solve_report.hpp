// SPDX-License-Identifier: Apache-2.0
// What the exact solver tells people and programs.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "first_report.hpp"
#include "hypgen/core/statistics.hpp"
#include "hypgen/exact/enumeration.hpp"
#include "hypgen/exact/interval.hpp"
#include "hypgen/model/descriptor.hpp"

namespace hypgen::exact {

// The sizes of an enumerated model, and what solving it gave.
struct SolveReport {
  EnumerationCounts counts;
  int classes = 0;
  int actions = 0;
  int observations = 0;
  std::size_t starts = 0;
  double enumeration_seconds = 0.0;
  IntervalResult result;
  std::vector<NamedDecision> first;
  nlohmann::ordered_json graph;  // of the policy; null if none is asked for
};

std::string table(const ModelDescriptor& model, const SolveReport& report);

// What a policy earned in its episodes.
std::string table(const std::string& policy, const Samples& returns);

// One line.
std::string json(const ModelDescriptor& model, const SolveReport& report);

// The progress of solving, for a terminal.
std::string status_line(const IntervalResult& result);

}  // namespace hypgen::exact
