// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/first_actions.hpp"

#include <algorithm>
#include <tuple>

namespace hypgen::exact {

namespace {

std::vector<ActionBounds> action_bounds(const SplitModel& split, BeliefGraph& graph, int node,
                                        const Slack& slack) {
  const std::vector<ClassAction>& actions = split.actions(graph[node].of_class);
  const double most = graph.upper(node);
  std::vector<ActionBounds> bounds;
  for (const int choice : graph.choices_by_upper(node)) {
    const auto i = static_cast<std::size_t>(choice);
    bounds.push_back({actions[i].action, graph.choice_lower(node, choice) - slack.lower,
                      std::min(graph[node].choices[i].upper, most) + slack.upper});
  }
  return bounds;
}

}  // namespace

double FirstDecision::regret() const {
  double most = 0.0;
  for (std::size_t i = 1; i < actions.size(); ++i) most = std::max(most, actions[i].upper - actions[0].lower);
  return most;
}

std::vector<FirstDecision> look_at_first_actions(const ExactModel& model, const SplitModel& split,
                                                 BeliefGraph& graph, const std::vector<int>& nodes,
                                                 const Slack& slack, double nothing,
                                                 const KeepGoing& may_look) {
  std::vector<FirstDecision> decisions(model.starts.size());
  for (std::size_t i = 0; i < decisions.size(); ++i) decisions[i].start = i;
  std::stable_sort(decisions.begin(), decisions.end(), [&](const FirstDecision& a, const FirstDecision& b) {
    return model.starts[a.start].probability > model.starts[b.start].probability;
  });
  decisions.resize(std::min(decisions.size(), kMostFirst));
  for (FirstDecision& decision : decisions) {
    const int node = nodes[decision.start];
    // Those that may be best come first, as time may not last for all.
    for (const int choice : graph.choices_by_upper(node)) {
      if (may_look()) graph.look_at(node, choice);
    }
    decision.actions = action_bounds(split, graph, node, slack);
  }
  for (const FirstDecision& decision : decisions) graph.back_up(nodes[decision.start], nothing);
  return decisions;
}

void choose_first_actions(const ExactModel& model, const AlphaPolicy& policy, double lower,
                          std::vector<FirstDecision>& decisions) {
  for (FirstDecision& decision : decisions) {
    decision.action = policy.action(model.starts[decision.start].belief);
    const auto key = [&](const ActionBounds& one) {
      return std::make_tuple(one.action != decision.action, -one.lower, -one.upper, one.action);
    };
    std::sort(decision.actions.begin(), decision.actions.end(),
              [&](const ActionBounds& a, const ActionBounds& b) { return key(a) < key(b); });
    if (model.starts.size() == 1 && !decision.actions.empty() &&
        decision.actions[0].action == decision.action) {
      decision.actions[0].lower = std::max(decision.actions[0].lower, lower);
    }
  }
}

}  // namespace hypgen::exact
