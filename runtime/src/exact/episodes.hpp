// SPDX-License-Identifier: Apache-2.0
// Episodes of policies on the exact belief, as the command line asks for them.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "exact_options.hpp"
#include "hypgen/core/statistics.hpp"
#include "hypgen/exact/exact_instance.hpp"
#include "hypgen/exact/interval.hpp"

namespace hypgen::exact {

using NamedPolicy = std::pair<std::string, const AlphaPolicy*>;

// The policy that --policy-kind calls so.
NamedPolicy policy_named(const IntervalSolution& solution, const std::string& kind);

// Plays the episodes that are asked for, adds their returns, and gives `write` a JSON line for each, as
// planners write them. False if `write` is, or after an interrupt.
bool play_policy(const ExactDescriptor& model, const ExactInstance& instance, const ExactModel& matrices,
                 const NamedPolicy& policy, const ExactOptions& options, Samples& returns,
                 const std::function<bool(const std::string&)>& write);

}  // namespace hypgen::exact
