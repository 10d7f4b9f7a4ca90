// SPDX-License-Identifier: Apache-2.0
// What first actions are worth, against values that are found by trying everything.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "exact_models.hpp"
#include "hypgen/exact/interval.hpp"

namespace hypgen::exact {
namespace {

IntervalSolution solve(const ExactModel& model, double gap, double seconds = 20.0) {
  IntervalOptions options;
  options.seconds = seconds;
  options.gap = gap;
  return solve_interval(model, options, [](const IntervalResult&) { return true; });
}

// The value of an action and of the best ones after it; -inf where it is not legal. For models with a horizon.
double value_by_trying(const ExactModel& model, const ExactAction& action, const Eigen::VectorXd& belief) {
  double value = 0.0;
  for (int s = 0; s < model.states; ++s) {
    if (belief[s] > 0.0) value += belief[s] * action.reward[s];
  }
  if (std::isinf(value)) return value;
  const Eigen::VectorXd columns = action.outcomes.transpose() * belief;
  for (std::size_t o = 0; o < action.observations.size(); ++o) {
    Eigen::VectorXd next = Eigen::VectorXd::Zero(model.states);
    for (int c = action.begin[o]; c < action.begin[o + 1]; ++c) {
      next[action.next[static_cast<std::size_t>(c)]] += columns[c];
    }
    if (!(next.sum() > 0.0)) continue;
    double best = -std::numeric_limits<double>::infinity();
    for (const ExactAction& other : model.actions) {
      best = std::max(best, value_by_trying(model, other, next / next.sum()));
    }
    value += model.discount * next.sum() * (std::isinf(best) ? 0.0 : best);
  }
  return value;
}

// The tiger with a horizon, where some first steps are left to choose.
ExactModel make_open_tiger(int steps) {
  ExactModel model = make_tiger_with_horizon(steps);
  for (int side = 0; side < 2; ++side) {
    model.actions[1].reward[side] = side == 0 ? -100.0 : 10.0;
    model.actions[2].reward[side] = side == 1 ? -100.0 : 10.0;
  }
  return model;
}

TEST(FirstActions, HoldTheValueOfEachAction) {
  const ExactModel model = make_open_tiger(5);
  const Eigen::VectorXd belief(model.starts[0].belief);
  for (const double seconds : {0.0, 1e-4, 20.0}) {
    const IntervalSolution solution = solve(model, 1e-9, seconds);
    ASSERT_EQ(solution.first.size(), 1u);
    ASSERT_EQ(solution.first[0].actions.size(), 3u);
    for (const ActionBounds& bounds : solution.first[0].actions) {
      const double value =
          value_by_trying(model, model.actions[static_cast<std::size_t>(bounds.action)], belief);
      EXPECT_LE(bounds.lower, value);
      EXPECT_GE(bounds.upper, value);
      if (seconds > 1.0) {
        EXPECT_NEAR(bounds.lower, value, 1e-7);
        EXPECT_NEAR(bounds.upper, value, 1e-7);
      }
    }
  }
}

TEST(FirstActions, AgreeWithTheIntervalAndThePolicy) {
  for (const double seconds : {0.0, 20.0}) {
    const ExactModel model = make_tiger();
    const IntervalSolution solution = solve(model, 1e-3, seconds);
    const FirstDecision& first = solution.first.at(0);
    EXPECT_EQ(first.action, solution.alpha.action(model.starts[0].belief));
    EXPECT_EQ(first.action, first.actions[0].action);
    double most = -std::numeric_limits<double>::infinity();
    for (const ActionBounds& bounds : first.actions) {
      EXPECT_LE(bounds.lower, bounds.upper);
      EXPECT_LE(bounds.upper, solution.result.upper + 1e-9);
      most = std::max(most, bounds.upper);
    }
    EXPECT_NEAR(first.actions[0].lower, solution.result.lower, 1e-9);
    EXPECT_NEAR(most, solution.result.upper, 1e-9);
  }
  const IntervalSolution solution = solve(make_tiger(), 1e-3);
  EXPECT_EQ(solution.first[0].action, 0);  // to listen
  EXPECT_EQ(solution.first[0].regret(), 0.0);
}

TEST(FirstActions, AreThoseAfterTheLikeliestStarts) {
  ExactModel model = make_tiger_with_horizon(5);
  model.starts[0].probability = 0.25;
  model.starts.push_back(make_start(model.states, 0.75, {4, 5}));
  const std::vector<FirstDecision> first = solve(model, 1e-9).first;
  ASSERT_EQ(first.size(), 2u);
  EXPECT_EQ(first[0].start, 1u);
  EXPECT_EQ(first[1].start, 0u);
  EXPECT_EQ(first[1].actions.size(), 1u);  // at first only listening is legal
  EXPECT_EQ(first[1].regret(), 0.0);
}

}  // namespace
}  // namespace hypgen::exact
