// SPDX-License-Identifier: Apache-2.0
// Small models as sparse matrices, written by hand.
#pragma once

#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "hypgen/exact/exact_model.hpp"

namespace hypgen::exact {

struct OutcomeEntry {
  int observation;
  int next;
  double probability;
};

// Sets what an action gives and leads to in each state.
inline ExactAction make_action(const std::vector<double>& rewards,
                               const std::vector<std::vector<OutcomeEntry>>& rows) {
  std::map<std::pair<int, int>, int> columns;
  for (const auto& row : rows) {
    for (const OutcomeEntry& entry : row) columns[{entry.observation, entry.next}] = 0;
  }
  ExactAction action;
  for (auto& [pair, column] : columns) {
    column = static_cast<int>(action.next.size());
    if (action.observations.empty() || action.observations.back() != pair.first) {
      action.observations.push_back(pair.first);
      action.begin.push_back(column);
    }
    action.next.push_back(pair.second);
  }
  action.begin.push_back(static_cast<int>(action.next.size()));
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t state = 0; state < rows.size(); ++state) {
    for (const OutcomeEntry& entry : rows[state]) {
      entries.emplace_back(static_cast<int>(state), columns[{entry.observation, entry.next}],
                           entry.probability);
    }
  }
  action.outcomes.resize(static_cast<int>(rows.size()), static_cast<int>(action.next.size()));
  action.outcomes.setFromTriplets(entries.begin(), entries.end());
  action.reward =
      Eigen::Map<const Eigen::VectorXd>(rewards.data(), static_cast<Eigen::Index>(rewards.size()));
  return action;
}

// An episode starts in some of the states, all of one class, with equal probability.
inline ExactStart make_start(int states, double probability, const std::vector<int>& first) {
  ExactStart start;
  start.probability = probability;
  start.belief.resize(states);
  for (const int state : first) start.belief.coeffRef(state) = 1.0 / static_cast<double>(first.size());
  return start;
}

inline void set_classes(ExactModel& model, const std::vector<int>& class_begin) {
  model.class_begin = class_begin;
  model.states = class_begin.back();
  model.seen.clear();
  for (int c = 0; c < model.classes(); ++c) {
    for (int s = class_begin[static_cast<std::size_t>(c)]; s < class_begin[static_cast<std::size_t>(c) + 1];
         ++s) {
      model.seen.push_back(c);
    }
  }
}

// The tiger: listening is right with 0.85; a door costs 100 or gives 10, and the tiger is placed again.
inline ExactModel make_tiger() {
  ExactModel model;
  model.discount = 0.95;
  model.observations = 2;
  set_classes(model, {0, 2});
  model.starts = {make_start(2, 1.0, {0, 1})};
  const std::vector<OutcomeEntry> again = {{0, 0, 0.25}, {0, 1, 0.25}, {1, 0, 0.25}, {1, 1, 0.25}};
  model.actions = {make_action({-1.0, -1.0}, {{{0, 0, 0.85}, {1, 0, 0.15}}, {{0, 1, 0.15}, {1, 1, 0.85}}}),
                   make_action({-100.0, 10.0}, {again, again}), make_action({10.0, -100.0}, {again, again})};
  return model;
}

// The tiger for some steps without discount, where a door ends the episode and nothing is legal after the
// last step but waiting. State (t, side) is 2 t + side; only the step is visible.
inline ExactModel make_tiger_with_horizon(int steps) {
  const double illegal = -std::numeric_limits<double>::infinity();
  ExactModel model;
  model.horizon = steps;
  model.observations = 2;
  std::vector<int> classes;
  std::vector<double> listen_rewards, left_rewards, right_rewards;
  std::vector<std::vector<OutcomeEntry>> listen, nothing;
  for (int t = 0; t < steps; ++t) {
    classes.push_back(2 * t);
    for (int side = 0; side < 2; ++side) {
      const int next = 2 * (t + 1) + side;
      const bool last = t + 1 == steps;
      listen.push_back(last ? std::vector<OutcomeEntry>{}
                            : std::vector<OutcomeEntry>{{side, next, 0.85}, {1 - side, next, 0.15}});
      listen_rewards.push_back(-1.0);
      left_rewards.push_back(t == 0 ? illegal : side == 0 ? -100.0 : 10.0);
      right_rewards.push_back(t == 0 ? illegal : side == 1 ? -100.0 : 10.0);
      nothing.emplace_back();
    }
  }
  classes.push_back(2 * steps);
  set_classes(model, classes);
  model.starts = {make_start(2 * steps, 1.0, {0, 1})};
  model.actions = {make_action(listen_rewards, listen), make_action(left_rewards, nothing),
                   make_action(right_rewards, nothing)};
  return model;
}

}  // namespace hypgen::exact
