// SPDX-License-Identifier: Apache-2.0
// What each action is worth at a first belief, between proven bounds.
#pragma once

#include <cstddef>
#include <vector>

#include "hypgen/exact/belief_graph.hpp"
#include "hypgen/exact/bounds.hpp"
#include "hypgen/exact/exact_model.hpp"
#include "hypgen/exact/policy.hpp"

namespace hypgen::exact {

// What rounding can have changed of a lower bound and of an upper one.
struct Slack {
  double lower;
  double upper;
};

// Taking an action and acting in the best way from then on is worth at least `lower` and at most `upper`.
struct ActionBounds {
  int action;
  double lower;
  double upper;
};

// The first decision after one way to start.
struct FirstDecision {
  std::size_t start = 0;              // index into `ExactModel::starts`
  int action = -1;                    // what the alpha vectors take; -1 where nothing is legal
  std::vector<ActionBounds> actions;  // all legal ones: `action`, then by lower bound, then by upper bound

  // The most by which another action can be better.
  double regret() const;
};

// Decisions after more starts than these are left out.
constexpr std::size_t kMostFirst = 100;

// The decisions after the likeliest starts, of which `nodes` are the beliefs, without `action` and not in order.
// Looks at what follows each action while `may_look` says so; other actions have the bounds that need no look.
// Lower bounds are moved down and upper ones up by `slack`. Then backs the beliefs up, so that what was found
// is in their bounds too.
std::vector<FirstDecision> look_at_first_actions(const ExactModel& model, const SplitModel& split,
                                                 BeliefGraph& graph, const std::vector<int>& nodes,
                                                 const Slack& slack, double nothing,
                                                 const KeepGoing& may_look);

// Fills in what the policy takes, and brings the actions in order. The policy is worth at least `lower`.
void choose_first_actions(const ExactModel& model, const AlphaPolicy& policy, double lower,
                          std::vector<FirstDecision>& decisions);

}  // namespace hypgen::exact
