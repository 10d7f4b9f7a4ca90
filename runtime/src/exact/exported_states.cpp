// SPDX-License-Identifier: Apache-2.0
#include "exported_states.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <utility>

namespace hypgen::exact {

namespace {

constexpr double kRounding = 1e-12;  // what probabilities lack of 1 by no more than this is nothing

// What is seen, and how likely: as text, in which probabilities have ten digits.
using Law = std::string;

struct Ways {
  double total = 0.0;
  std::vector<std::pair<int, double>> seen;  // by observation
};

// An action that is not legal does what the first legal one does; null where none is.
const ExactAction* action_in(const ExactModel& model, std::size_t action, int state) {
  if (!std::isinf(model.actions[action].reward[state])) return &model.actions[action];
  for (const ExactAction& other : model.actions) {
    if (!std::isinf(other.reward[state])) return &other;
  }
  return nullptr;
}

std::map<int, Ways> ways_from(const ExactAction& action, int state) {
  std::map<int, Ways> reached;
  std::size_t group = 0;
  for (SparseMatrix::InnerIterator entry(action.outcomes, state); entry; ++entry) {
    const auto column = static_cast<int>(entry.col());
    while (action.begin[group + 1] <= column) ++group;
    Ways& ways = reached[action.next[static_cast<std::size_t>(column)]];
    ways.total += entry.value();
    ways.seen.emplace_back(action.observations[group], entry.value());
  }
  return reached;
}

Law law_of(const Ways& ways) {
  Law law;
  for (const auto& [observation, probability] : ways.seen) {
    char text[48];
    std::snprintf(text, sizeof text, "%d:%.10g ", observation, probability / ways.total);
    law += text;
  }
  return law;
}

}  // namespace

ExportedStates::ExportedStates(const ExactModel& model) {
  std::vector<std::size_t> copies(static_cast<std::size_t>(model.states), 1);
  for (std::size_t a = 0; a < model.actions.size(); ++a) {
    std::vector<std::vector<Law>> laws(static_cast<std::size_t>(model.states));  // on arriving in each state
    for (int from = 0; from < model.states; ++from) {
      const ExactAction* const action = action_in(model, a, from);
      double left = 1.0;
      if (action != nullptr) {
        for (const auto& [next, ways] : ways_from(*action, from)) {
          left -= ways.total;
          std::vector<Law>& known = laws[static_cast<std::size_t>(next)];
          const Law law = law_of(ways);
          if (std::find(known.begin(), known.end(), law) == known.end()) known.push_back(law);
        }
      }
      ended = ended || left > kRounding;
    }
    for (std::size_t s = 0; s < copies.size(); ++s) copies[s] = std::max(copies[s], laws[s].size());
  }
  for (int s = 0; s < model.states; ++s) state.insert(state.end(), copies[static_cast<std::size_t>(s)], s);
}

}  // namespace hypgen::exact
