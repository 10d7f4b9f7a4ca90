// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/split_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace hypgen::exact {
namespace {

// Probabilities that add up to less leave something for an episode's end.
constexpr double kWhole = 1.0 - 1e-12;

double discounted_steps(const ExactModel& model) {
  if (model.discount < 1.0 && model.horizon == 0) return 1.0 / (1.0 - model.discount);
  if (model.horizon == 0) return std::numeric_limits<double>::infinity();
  double steps = 0.0;
  for (int i = 0; i < model.horizon; ++i) steps = 1.0 + model.discount * steps;
  return steps;
}

// Numbers the columns that occur in rows [first, last) in `local` (-1: not met) and returns them, ascending.
std::vector<int> columns_of(const SparseMatrix& outcomes, int first, int last, std::vector<int>& local) {
  std::vector<int> columns;
  for (int state = first; state < last; ++state) {
    for (SparseMatrix::InnerIterator entry(outcomes, state); entry; ++entry) {
      auto& met = local[static_cast<std::size_t>(entry.col())];
      if (met < 0) columns.push_back(static_cast<int>(entry.col()));
      met = 0;
    }
  }
  std::sort(columns.begin(), columns.end());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    local[static_cast<std::size_t>(columns[i])] = static_cast<int>(i);
  }
  return columns;
}

// Groups sorted columns by what is seen with them.
void add_outcomes(const ExactModel& model, const ExactAction& from, const std::vector<int>& columns,
                  ClassAction& to) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const int next = from.next[static_cast<std::size_t>(columns[i])];
    const auto after = std::upper_bound(from.begin.begin(), from.begin.end(), columns[i]);
    const auto seen = static_cast<std::size_t>(after - from.begin.begin() - 1);
    const int observation = from.observations[seen];
    const int next_class = model.seen[static_cast<std::size_t>(next)];
    const int column = static_cast<int>(i);
    if (to.outcomes.empty() || to.outcomes.back().observation != observation ||
        to.outcomes.back().next_class != next_class) {
      Outcome& outcome = to.outcomes.emplace_back();
      outcome.observation = observation;
      outcome.next_class = next_class;
      outcome.begin = column;
    }
    to.outcomes.back().end = column + 1;
    to.next.push_back(next);
    to.outcome_of.push_back(static_cast<int>(to.outcomes.size()) - 1);
  }
}

// States that are never left and earn nothing, whatever is done: to reach them is an end.
std::vector<char> free_states(const ExactModel& model) {
  std::vector<char> free(static_cast<std::size_t>(model.states), 1);
  std::vector<std::vector<int>> before(free.size());
  std::vector<int> left;
  for (int state = 0; state < model.states; ++state) {
    bool pays = false;
    for (const ExactAction& action : model.actions) {
      pays = pays || (std::isfinite(action.reward[state]) && action.reward[state] != 0.0);
      for (SparseMatrix::InnerIterator entry(action.outcomes, state); entry; ++entry) {
        before[static_cast<std::size_t>(action.next[static_cast<std::size_t>(entry.col())])].push_back(state);
      }
    }
    free[static_cast<std::size_t>(state)] = pays ? 0 : 1;
    if (pays) left.push_back(state);
  }
  for (std::size_t i = 0; i < left.size(); ++i) {
    for (const int state : before[static_cast<std::size_t>(left[i])]) {
      if (free[static_cast<std::size_t>(state)] == 0) continue;
      free[static_cast<std::size_t>(state)] = 0;
      left.push_back(state);
    }
  }
  return free;
}

ClassAction class_action(const ExactModel& model, const std::vector<char>& free, int action, int first,
                         int last, std::vector<int>& local) {
  const ExactAction& from = model.actions[static_cast<std::size_t>(action)];
  local.resize(std::max(local.size(), from.next.size()), -1);
  const std::vector<int> columns = columns_of(from.outcomes, first, last, local);
  ClassAction to;
  to.action = action;
  add_outcomes(model, from, columns, to);
  to.row_begin.push_back(0);
  for (int state = first; state < last; ++state) {
    to.reward.push_back(from.reward[state]);
    for (SparseMatrix::InnerIterator entry(from.outcomes, state); entry; ++entry) {
      if (!free.empty() &&
          free[static_cast<std::size_t>(from.next[static_cast<std::size_t>(entry.col())])] != 0)
        continue;
      to.column.push_back(local[static_cast<std::size_t>(entry.col())]);
      to.weight.push_back(entry.value());
    }
    to.row_begin.push_back(static_cast<int>(to.column.size()));
  }
  for (const int column : columns) local[static_cast<std::size_t>(column)] = -1;
  return to;
}

}  // namespace

SplitModel::SplitModel(const ExactModel& model)
    : discount_(model.discount),
      recurs_(model.horizon == 0),
      steps_(discounted_steps(model)),
      class_begin_(model.class_begin) {
  std::vector<int> local;
  const std::vector<char> free = is_endless() ? free_states(model) : std::vector<char>();
  for (int c = 0; c < model.classes(); ++c) add_class(model, free, c, local);
  std::size_t longest = 1;
  for (const auto& of_class : actions_) {
    for (const ClassAction& action : of_class) {
      for (std::size_t i = 0; i + 1 < action.row_begin.size(); ++i) {
        longest = std::max(longest, static_cast<std::size_t>(action.row_begin[i + 1] - action.row_begin[i]));
      }
      longest = std::max(longest, action.reward.size());
      branches_ += action.reward.size() * action.outcomes.size();
    }
  }
  // A backup adds at most `longest` products for a row and as many for a belief, each with a relative error
  // of half an epsilon, and beliefs that are four epsilons apart in each state count as one
  // (`belief_graph.cpp`). A mixture may have an epsilon more of each state (`mixture.cpp`). Every step of an
  // episode adds the same.
  rounding_of_step_ = 8.0 * static_cast<double>(longest + 16) * std::numeric_limits<double>::epsilon();
}

void SplitModel::limit_steps(double steps) { steps_ = steps; }

void SplitModel::add_class(const ExactModel& model, const std::vector<char>& free, int of_class,
                           std::vector<int>& local) {
  const int begin = first(of_class);
  actions_.emplace_back();
  for (int action = 0; action < static_cast<int>(model.actions.size()); ++action) {
    const auto& reward = model.actions[static_cast<std::size_t>(action)].reward;
    if (std::isinf(reward[begin])) continue;  // legality is the same in all states of a class
    actions_.back().push_back(class_action(model, free, action, begin, first(of_class + 1), local));
    const ClassAction& added = actions_.back().back();
    for (const double value : added.reward) largest_reward_ = std::max(largest_reward_, std::abs(value));
    for (std::size_t s = 0; s < added.reward.size() && !ends_; ++s) {
      const auto row = added.weight.begin();
      ends_ = std::accumulate(row + added.row_begin[s], row + added.row_begin[s + 1], 0.0) < kWhole;
    }
  }
  ends_ = ends_ || actions_.back().empty();
}

}  // namespace hypgen::exact
