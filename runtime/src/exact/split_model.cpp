// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/split_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace hypgen::exact {
namespace {

double discounted_steps(const ExactModel& model) {
  if (model.discount < 1.0 && model.horizon == 0) return 1.0 / (1.0 - model.discount);
  if (model.horizon == 0) throw std::invalid_argument("a discount of 1 needs a horizon");
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

ClassAction class_action(const ExactModel& model, int action, int first, int last, std::vector<int>& local) {
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
    : discount_(model.discount), steps_(discounted_steps(model)), class_begin_(model.class_begin) {
  std::vector<int> local;
  for (int c = 0; c < model.classes(); ++c) add_class(model, c, local);
  std::size_t longest = 1;
  for (const auto& of_class : actions_) {
    for (const ClassAction& action : of_class) {
      for (std::size_t i = 0; i + 1 < action.row_begin.size(); ++i) {
        longest = std::max(longest, static_cast<std::size_t>(action.row_begin[i + 1] - action.row_begin[i]));
      }
      longest = std::max(longest, action.reward.size());
    }
  }
  // A backup adds at most `longest` products for a row and as many for a belief, each with a relative error
  // of half an epsilon, and beliefs that are four epsilons apart in each state count as one
  // (`belief_graph.cpp`). Every step of an episode adds the same.
  rounding_ = 8.0 * static_cast<double>(longest + 16) * std::numeric_limits<double>::epsilon() * steps_;
}

void SplitModel::add_class(const ExactModel& model, int of_class, std::vector<int>& local) {
  const int begin = first(of_class);
  actions_.emplace_back();
  for (int action = 0; action < static_cast<int>(model.actions.size()); ++action) {
    const auto& reward = model.actions[static_cast<std::size_t>(action)].reward;
    if (std::isinf(reward[begin])) continue;  // legality is the same in all states of a class
    actions_.back().push_back(class_action(model, action, begin, first(of_class + 1), local));
    for (const double value : actions_.back().back().reward) {
      largest_reward_ = std::max(largest_reward_, std::abs(value));
    }
  }
}

}  // namespace hypgen::exact
