// SPDX-License-Identifier: Apache-2.0
// Policies that see the state and go on for very many steps: their values by linear equations, where sweeps
// would take about as many as the episode has steps.
#pragma once

#include "hypgen/exact/bounds.hpp"

namespace hypgen::exact {

// An index into `SplitModel::actions` of each state's class, -1 where nothing is legal.
using StatePolicy = std::vector<int>;

// What the policy earns. Empty if it goes on for ever at a discount of 1, or if the states are too many.
StateValues direct_policy_values(const SplitModel& model, const StatePolicy& policy);

// Values of the policy that is best (`direction` 1) or worst (-1), by policy iteration, but for rounding.
// Empty as above.
StateValues direct_mdp_values(const SplitModel& model, double direction);

// The fast informed bound, but for rounding. Empty if states and actions are too many.
ActionValues direct_fib_values(const SplitModel& model, const ActionValues& start);

// What acting at random earns, all legal actions alike. Empty as above.
StateValues random_values(const SplitModel& model);

// How many steps a policy takes at most on average, from any state, if it is worth as much as acting at
// random. Throws std::invalid_argument, which says why, unless every policy that never ends costs without
// bound: then no value can be proven.
double steps_to_end(const SplitModel& model);

}  // namespace hypgen::exact
