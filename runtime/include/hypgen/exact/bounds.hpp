// SPDX-License-Identifier: Apache-2.0
// Bounds of a small model's values that need no search (Hauskrecht, "Value-function approximations for
// partially observable Markov decision processes", JAIR 2000).
//
// All are made by sweeps that start on the safe side and only come closer, so a sweep that is cut short gives
// a sound bound as well. `keep_going` is asked about after each sweep.
#pragma once

#include <functional>
#include <vector>

#include "hypgen/exact/split_model.hpp"

namespace hypgen::exact {

using KeepGoing = std::function<bool()>;

// Of each state of the model.
using StateValues = std::vector<double>;

// Of each class: a row of values for each of its states, a column for each action that is legal in the class.
using ActionValues = std::vector<std::vector<double>>;

// At least the discounted steps of an episode from any state, whatever is done.
double longest_stay(const SplitModel& model, const KeepGoing& keep_going);

// At least the value of an agent that sees the state.
StateValues mdp_values(const SplitModel& model, const KeepGoing& keep_going);

// At most the value of any policy: that of the worst one which sees the state. Where `is_endless`, as some
// policies have no value, that of acting at random.
StateValues worst_values(const SplitModel& model, const KeepGoing& keep_going);

// The value of taking an action and seeing the state from then on.
ActionValues qmdp_values(const SplitModel& model, const StateValues& mdp);

// The fast informed bound: of taking an action and seeing, one step late, all states.
ActionValues fib_values(const SplitModel& model, ActionValues start, const KeepGoing& keep_going);

// The actions of a policy that only looks at the class: an index into `SplitModel::actions` of each class, -1
// where nothing is legal.
using ClassPolicy = std::vector<int>;

// Always `action`; where that is not legal, the first that is.
ClassPolicy blind_policy(const SplitModel& model, int action);

// At most what the policy is worth; empty if it never ends where it has to.
StateValues policy_values(const SplitModel& model, const ClassPolicy& policy, const KeepGoing& keep_going);

// The most that an action value of a belief in the class is: of states (numbered from the class's first) and
// their probabilities.
double best_value(const SplitModel& model, const ActionValues& values, int of_class,
                  const std::vector<int>& states, const std::vector<double>& probabilities);

}  // namespace hypgen::exact
