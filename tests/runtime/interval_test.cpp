// Intervals of values of small models, against values that are known or found by trying everything.
#include "hypgen/exact/interval.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <string>

#include "exact_models.hpp"

namespace hypgen::exact {
namespace {

const IntervalProgress kGoOn = [](const IntervalResult&) { return true; };

IntervalSolution solve(const ExactModel& model, double gap) {
  IntervalOptions options;
  options.seconds = 20.0;
  options.gap = gap;
  return solve_interval(model, options, kGoOn);
}

// The value of the best policy, by trying all actions at all beliefs: for models with a horizon.
double value_by_trying(const ExactModel& model, const Eigen::VectorXd& belief) {
  double best = -std::numeric_limits<double>::infinity();
  for (const ExactAction& action : model.actions) {
    double value = 0.0;
    for (int s = 0; s < model.states; ++s) {
      if (belief[s] > 0.0) value += belief[s] * action.reward[s];
    }
    if (std::isinf(value)) continue;
    const Eigen::VectorXd columns = action.outcomes.transpose() * belief;
    for (std::size_t o = 0; o < action.observations.size(); ++o) {
      Eigen::VectorXd next = Eigen::VectorXd::Zero(model.states);
      for (int c = action.begin[o]; c < action.begin[o + 1]; ++c) {
        next[action.next[static_cast<std::size_t>(c)]] += columns[c];
      }
      if (next.sum() > 0.0) value += model.discount * next.sum() * value_by_trying(model, next / next.sum());
    }
    best = std::max(best, value);
  }
  return std::isinf(best) ? 0.0 : best;
}

TEST(Interval, OfTheTigerIsTheOneOfTheLiterature) {
  const IntervalSolution solution = solve(make_tiger(), 1e-5);
  EXPECT_TRUE(solution.result.converged());
  EXPECT_LE(solution.result.lower, 19.3714);
  EXPECT_GE(solution.result.upper, 19.3713);
  EXPECT_LT(solution.result.upper - solution.result.lower, 1e-3);
  EXPECT_LT(solution.result.seconds, 1.0);
}

TEST(Interval, OrdersTheSimplerBounds) {
  const IntervalResult result = solve(make_tiger(), 1e-3).result;
  EXPECT_GE(result.mdp, result.qmdp);
  EXPECT_GE(result.qmdp, result.fib);
  EXPECT_GE(result.fib, result.upper);
  EXPECT_LE(result.blind, result.lower);
  EXPECT_NEAR(result.mdp, 200.0, 1e-3);    // always 10
  EXPECT_NEAR(result.qmdp, 189.0, 1e-3);   // listen once, then always 10
  EXPECT_NEAR(result.blind, -20.0, 1e-3);  // listen for ever
}

TEST(Interval, HoldsTheValueOfAModelWithAHorizon) {
  const ExactModel model = make_tiger_with_horizon(6);
  const double value = value_by_trying(model, Eigen::VectorXd(model.starts[0].belief));
  const IntervalResult result = solve(model, 1e-9).result;
  EXPECT_TRUE(result.converged());
  EXPECT_NEAR(result.lower, value, 1e-8);
  EXPECT_NEAR(result.upper, value, 1e-8);
  EXPECT_LE(result.lower, value);
  EXPECT_GE(result.upper, value);
}

TEST(Interval, WeighsSeveralStarts) {
  ExactModel model = make_tiger_with_horizon(5);
  const double first = value_by_trying(model, Eigen::VectorXd(model.starts[0].belief));
  model.starts[0].probability = 0.25;
  model.starts.push_back(make_start(model.states, 0.75, {4, 5}));
  const double second = value_by_trying(model, Eigen::VectorXd(model.starts[1].belief));
  const IntervalResult result = solve(model, 1e-9).result;
  EXPECT_NEAR(result.lower, 0.25 * first + 0.75 * second, 1e-8);
  EXPECT_NEAR(result.upper, 0.25 * first + 0.75 * second, 1e-8);
}

TEST(Interval, IsSoundWheneverItIsStopped) {
  const ExactModel model = make_tiger();
  for (const double seconds : {0.0, 1e-5, 1e-4, 1e-3}) {
    IntervalOptions options;
    options.seconds = seconds;
    options.gap = 0.0;
    const IntervalSolution solution = solve_interval(model, options, kGoOn);
    EXPECT_EQ(solution.result.end, IntervalEnd::kTime);
    EXPECT_LE(solution.result.lower, 19.3714);
    EXPECT_GE(solution.result.upper, 19.3713);
  }
}

TEST(Interval, StopsWhenAskedTo) {
  IntervalOptions options;
  options.gap = 0.0;
  options.seconds = 20.0;
  const IntervalSolution solution =
      solve_interval(make_tiger(), options, [](const IntervalResult&) { return false; });
  EXPECT_EQ(solution.result.end, IntervalEnd::kStopped);
  EXPECT_LT(solution.result.seconds, 10.0);
}

TEST(Interval, GoesOnInLittleMemory) {
  IntervalOptions options;
  options.gap = 1e-4;
  options.seconds = 20.0;
  options.bytes = 20'000;
  const IntervalResult result = solve_interval(make_tiger(), options, kGoOn).result;
  EXPECT_LE(result.lower, 19.3714);
  EXPECT_GE(result.upper, 19.3713);
  options.bytes = 100;
  EXPECT_EQ(solve_interval(make_tiger(), options, kGoOn).result.end, IntervalEnd::kMemory);
}

TEST(Interval, NeedsADiscountOrAHorizon) {
  ExactModel model = make_tiger();
  model.discount = 1.0;
  EXPECT_THROW(solve(model, 1e-3), std::invalid_argument);
}

TEST(AlphaPolicy, IsWorthTheLowerEnd) {
  const ExactModel model = make_tiger();
  const IntervalSolution solution = solve(model, 1e-5);
  const SparseBelief& start = model.starts[0].belief;
  EXPECT_NEAR(solution.alpha.value(start), solution.result.lower, 1e-6);
  EXPECT_EQ(solution.alpha.action(start), 0);
  SparseBelief sure(2);
  sure.insert(0) = 0.99;
  sure.insert(1) = 0.01;
  EXPECT_EQ(solution.alpha.action(sure), 2);
  EXPECT_EQ(solution.blind.action(sure), 0);
  EXPECT_EQ(solution.qmdp.action(sure), 2);
}

TEST(AlphaPolicy, ComesBackFromItsFile) {
  const ExactModel model = make_tiger_with_horizon(4);
  const AlphaPolicy policy = solve(model, 1e-6).alpha;
  std::stringstream file;
  write_policy(file, model, policy);
  const AlphaPolicy back = read_policy(file, model);
  ASSERT_EQ(back.vectors().size(), policy.vectors().size());
  for (std::size_t c = 0; c < back.vectors().size(); ++c) {
    ASSERT_EQ(back.vectors()[c].size(), policy.vectors()[c].size());
    for (std::size_t i = 0; i < back.vectors()[c].size(); ++i) {
      EXPECT_EQ(back.vectors()[c][i].action, policy.vectors()[c][i].action);
      EXPECT_EQ(back.vectors()[c][i].values, policy.vectors()[c][i].values);
    }
  }
}

TEST(AlphaPolicy, RefusesFilesOfOtherModelsAndDamagedOnes) {
  const ExactModel model = make_tiger();
  std::stringstream file;
  write_policy(file, model, solve(model, 1e-3).alpha);
  const std::string text = file.str();
  ExactModel other = make_tiger();
  other.actions[0].reward[0] = -2.0;
  std::istringstream whole(text);
  EXPECT_THROW(read_policy(whole, other), PolicyError);
  std::istringstream part(text.substr(0, text.size() / 2));
  EXPECT_THROW(read_policy(part, model), PolicyError);
  std::istringstream nothing("");
  EXPECT_THROW(read_policy(nothing, model), PolicyError);
}

}  // namespace
}  // namespace hypgen::exact
