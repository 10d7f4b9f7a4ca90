// SPDX-License-Identifier: Apache-2.0
// Intervals of values of small models, against values that are known or found by trying everything.
#include "hypgen/exact/interval.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <string>
#include <tuple>

#include "exact_models.hpp"
#include "hypgen/exact/alpha_vectors.hpp"
#include "hypgen/exact/sawtooth.hpp"

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

// A machine that wears out and is heard: beliefs lie everywhere between its four states, so points have to bound
// what is between them.
ExactModel make_worn_machine() {
  ExactModel model;
  model.discount = 0.99999;
  model.observations = 2;
  set_classes(model, {0, 4});
  model.starts = {make_start(4, 1.0, {0})};
  const auto rows = [](const std::vector<double>& quiet, bool repairs) {
    std::vector<std::vector<OutcomeEntry>> result;
    for (int state = 0; state < 4; ++state) {
      std::vector<OutcomeEntry> entries;
      for (const int observation : {0, 1}) {
        for (const int next : {state, state + 1}) {
          const double moves = state == 3 ? 0.0 : 0.05;
          double p = next == state ? 1.0 - moves : moves;
          if (repairs) p = next == 0 ? 1.0 : 0.0;
          const double heard = next > 3 ? 0.0 : quiet[static_cast<std::size_t>(next)];
          if (p > 0.0) entries.push_back({observation, next, p * (observation == 0 ? heard : 1.0 - heard)});
        }
        if (repairs && state > 0) entries.push_back({observation, 0, 0.5});
      }
      result.push_back(std::move(entries));
    }
    return result;
  };
  const std::vector<double> blind{0.5, 0.5, 0.5, 0.5};
  model.actions = {make_action({1.0, 0.9, 0.6, 0.0}, rows(blind, false)),
                   make_action({0.9, 0.8, 0.5, -0.1}, rows({0.95, 0.8, 0.3, 0.05}, false)),
                   make_action({-4.0, -4.0, -4.0, -4.0}, rows(blind, true))};
  return model;
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
    EXPECT_FALSE(solution.result.converged());
    EXPECT_LE(solution.result.lower, 19.3714);
    EXPECT_GE(solution.result.upper, 19.3713);
  }
}

TEST(Interval, EndsWhereRoundingIsAllThatIsLeft) {
  const IntervalResult result = solve(make_tiger(), 0.0).result;
  EXPECT_EQ(result.end, IntervalEnd::kRounding);
  EXPECT_LT(result.upper - result.lower, 1e-6);
  EXPECT_LT(result.seconds, 1.0);
}

TEST(Interval, StopsWhenAskedTo) {
  IntervalOptions options;
  options.seconds = 20.0;
  options.gap = 0.0;
  const IntervalSolution solution =
      solve_interval(make_worn_machine(), options, [](const IntervalResult&) { return false; });
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

// The tiger's arithmetic at a discount near 1: listening until it is heard twice more on one side than on the
// other, for ever.
TEST(Interval, IsClosedOverLongEpisodes) {
  ExactModel model = make_tiger();
  model.discount = 0.99999;
  const IntervalResult result = solve(model, 1e-6).result;
  EXPECT_TRUE(result.converged());
  EXPECT_NEAR(result.lower, 108376.6, 0.2);
  EXPECT_NEAR(result.upper, 108376.6, 0.2);
  EXPECT_LT(result.seconds, 5.0);
}

// A machine wears out by and by; a repair costs 4. Most of a long run's value comes from repairs in time.
TEST(Interval, FindsLoopsOfLongEpisodes) {
  ExactModel model;
  model.discount = 0.99999;
  model.observations = 1;
  set_classes(model, {0, 3});
  model.starts = {make_start(3, 1.0, {0})};
  model.actions = {
      make_action({1.0, 0.6, 0.0}, {{{0, 0, 0.9}, {0, 1, 0.1}}, {{0, 1, 0.9}, {0, 2, 0.1}}, {{0, 2, 1.0}}}),
      make_action({-4.0, -4.0, -4.0}, {{{0, 0, 1.0}}, {{0, 0, 1.0}}, {{0, 0, 1.0}}})};
  const IntervalResult result = solve(model, 1e-4).result;
  // A repair after every n steps, of which the best n is 15.
  double best = 0.0;
  for (int n = 1; n < 100; ++n) {
    double now[3] = {1.0, 0.0, 0.0}, earned = 0.0, weight = 1.0;
    for (int i = 0; i < n; ++i, weight *= model.discount) {
      earned += weight * (now[0] + 0.6 * now[1]);
      now[2] += 0.1 * now[1];
      now[1] = 0.9 * now[1] + 0.1 * now[0];
      now[0] *= 0.9;
    }
    best = std::max(best, (earned - 4.0 * weight) / (1.0 - weight * model.discount));
  }
  EXPECT_TRUE(result.converged());
  EXPECT_LE(result.lower, best);
  EXPECT_GE(result.upper, best);
}

TEST(Interval, MixesPointsOfLongEpisodes) {
  const IntervalResult result = solve(make_worn_machine(), 3e-4).result;
  EXPECT_TRUE(result.converged());
  EXPECT_GT(result.upper, result.lower);
  EXPECT_LT(result.seconds, 10.0);
}

// Each step ends the episode in one case of ten, in one of two states that look alike and where nothing is
// legal. It pays 1.5 to who knows the state and never less than 0.5, so values lie between those of all.
TEST(Interval, EndsWithTheEpisode) {
  const double never = -std::numeric_limits<double>::infinity();
  ExactModel model;
  model.discount = 0.95;
  model.observations = 2;
  set_classes(model, {0, 2, 4});
  model.starts = {make_start(4, 0.5, {0, 1}), make_start(4, 0.5, {2, 3})};
  const std::vector<OutcomeEntry> row{{0, 0, 0.6}, {0, 1, 0.3}, {1, 2, 0.05}, {1, 3, 0.05}};
  const std::vector<OutcomeEntry> other{{0, 0, 0.2}, {0, 1, 0.7}, {1, 2, 0.08}, {1, 3, 0.02}};
  model.actions = {make_action({1.5, 0.5, never, never}, {row, other, {}, {}}),
                   make_action({0.5, 1.5, never, never}, {row, other, {}, {}})};
  const double steps = 0.5 / (1.0 - 0.95 * 0.9);
  const IntervalResult result = solve(model, 0.0).result;
  EXPECT_LE(result.lower, result.upper);
  EXPECT_GT(result.lower, 0.5 * steps);
  EXPECT_LT(result.upper, 1.5 * steps);
  EXPECT_LT(result.upper - result.lower, 1e-5);
}

// A goal that is free and never left, at a discount of 1. Fast costs 2, slow costs 1.
ExactModel make_paths(double near_cost, double near_to_goal) {
  ExactModel model;
  model.observations = 2;
  set_classes(model, {0, 3});
  model.starts = {make_start(3, 1.0, {0})};
  const auto row = [](double far, double near, double goal) {
    std::vector<OutcomeEntry> entries;
    for (const auto& [next, p, dark] :
         {std::tuple{0, far, 0.9}, std::tuple{1, near, 0.6}, std::tuple{2, goal, 0.0}}) {
      if (p * dark > 0.0) entries.push_back({0, next, p * dark});
      if (p > 0.0) entries.push_back({1, next, p * (1.0 - dark)});
    }
    return entries;
  };
  model.actions = {
      make_action({-1.0, near_cost, 0.0},
                  {row(0.5, 0.5, 0.0), row(0.0, 1.0 - near_to_goal, near_to_goal), row(0.0, 0.0, 1.0)}),
      make_action({-2.0, -2.0, 0.0}, {row(0.2, 0.5, 0.3), row(0.3, 0.0, 0.7), row(0.0, 0.0, 1.0)})};
  return model;
}

TEST(Interval, OfAShortestPathNeedsNoDiscount) {
  const IntervalResult result = solve(make_paths(-1.0, 0.5), 1e-6).result;
  EXPECT_TRUE(result.converged());
  EXPECT_NEAR(result.lower, -3.8, 1e-5);
  EXPECT_NEAR(result.upper, -3.8, 1e-5);
}

TEST(Interval, RefusesToGoOnForEverAtNoCost) {
  EXPECT_THROW(solve(make_paths(0.0, 0.0), 1e-3), std::invalid_argument);
  EXPECT_NO_THROW(solve(make_paths(0.0, 0.5), 1e-3));
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

// Three places in a ring: leaving the last one earns 1, standing still nothing. The loop's vectors come from
// equations, and the policy needs those of all its places.
TEST(AlphaPolicy, EarnsTheLowerEndOfALoop) {
  ExactModel model;
  model.discount = 0.95;
  model.observations = 1;
  set_classes(model, {0, 3});
  model.starts = {make_start(3, 1.0, {0})};
  model.actions = {make_action({0.0, 0.0, 0.0}, {{{0, 0, 1.0}}, {{0, 1, 1.0}}, {{0, 2, 1.0}}}),
                   make_action({0.0, 0.0, 1.0}, {{{0, 1, 1.0}}, {{0, 2, 1.0}}, {{0, 0, 1.0}}})};
  const IntervalSolution solution = solve(model, 1e-6);
  double earned = 0.0;
  double weight = 1.0;
  int place = 0;
  for (int step = 0; step < 400; ++step, weight *= model.discount) {
    const auto action = static_cast<std::size_t>(solution.alpha.action(make_start(3, 1.0, {place}).belief));
    earned += weight * model.actions[action].reward[place];
    if (action == 1) place = (place + 1) % 3;
  }
  EXPECT_NEAR(earned, solution.result.lower, 1e-5);
}

void expect_equal(const AlphaPolicy& a, const AlphaPolicy& b) {
  ASSERT_EQ(a.classes().size(), b.classes().size());
  for (std::size_t c = 0; c < a.classes().size(); ++c) {
    const AlphaPolicy::Class& one = a.classes()[c];
    const AlphaPolicy::Class& other = b.classes()[c];
    EXPECT_EQ(one.rest, other.rest);
    ASSERT_EQ(one.vectors.size(), other.vectors.size());
    for (std::size_t i = 0; i < one.vectors.size(); ++i) {
      EXPECT_EQ(one.vectors[i].action, other.vectors[i].action);
      EXPECT_EQ(one.vectors[i].states, other.vectors[i].states);
      EXPECT_EQ(one.vectors[i].values, other.vectors[i].values);
    }
  }
}

TEST(AlphaPolicy, ListsOnlySomeStatesOfAVector) {
  const ExactModel model = make_tiger();
  const AlphaPolicy policy(model, {{{{1, {}, {1.0, 1.0}}, {2, {1}, {4.0}}}, {-5.0, -3.0}}});
  SparseBelief sure(2);
  sure.insert(1) = 1.0;
  EXPECT_EQ(policy.action(sure), 2);
  EXPECT_EQ(policy.value(sure), 4.0);
  EXPECT_EQ(policy.action(model.starts[0].belief), 1);  // 0.5 (-5 + 4) is less than 1
  std::stringstream file;
  write_policy(file, model, policy);
  expect_equal(read_policy(file, model), policy);
}

TEST(AlphaVectors, ArePrunedWhereAnotherIsNowhereLess) {
  AlphaVectors vectors({-5.0, -3.0, -1.0});
  auto make = [number = std::uint64_t{0}](std::vector<int> states, std::vector<double> values) mutable {
    AlphaVector vector;
    vector.number = number++;
    vector.choice = 0;
    vector.states = std::move(states);
    vector.values = std::move(values);
    return vector;
  };
  const AlphaVector* low = vectors.add(make({}, {-4.0, 0.0, 0.0}));
  EXPECT_EQ(vectors.add(make({1}, {-0.5})), low);  // elsewhere it is the worst value
  const AlphaVector* some = vectors.add(make({1, 2}, {1.0, -0.5}));
  EXPECT_EQ(vectors.vectors().size(), 2u);
  EXPECT_EQ(vectors.value(*some, ClassBelief{{0, 1}, {0.5, 0.5}}), -2.0);
  const AlphaVector* high = vectors.add(make({}, {-4.0, 1.0, 0.0}));
  EXPECT_EQ(low->current(), high);
  EXPECT_EQ(some->current(), high);
  EXPECT_EQ(vectors.vectors().size(), 1u);
  EXPECT_EQ(vectors.usual(), high);
  double value = -100.0;
  const AlphaVector* best = nullptr;
  vectors.raise(ClassBelief{{0, 1}, {0.5, 0.5}}, 0, value, best);
  EXPECT_EQ(best, high);
  EXPECT_EQ(value, -1.5);
}

TEST(Sawtooth, LiesBetweenItsPointsAndTheConvexBound) {
  Sawtooth upper({10.0, 0.0, 0.0, 10.0}, 2, 2);  // one action pays in one state, the other in the other
  const ClassBelief middle{{0, 1}, {0.5, 0.5}};
  const ClassBelief aside{{0, 1}, {0.75, 0.25}};
  int at = -1;
  EXPECT_EQ(upper.lowest(aside, upper.base(aside), 0, 7.5), 7.5);
  upper.lower(middle, upper.base(middle), 2.0, 0, at);
  EXPECT_EQ(upper.lowest(middle, upper.base(middle), 0, 5.0), 2.0);
  // Half of it is the point; the rest is state 0 for sure, worth 10 there.
  EXPECT_EQ(upper.lowest(aside, upper.base(aside), 0, 7.5), 0.5 * 2.0 + 0.5 * 10.0);
  upper.lower(middle, upper.base(middle), 1.0, 1, at);
  EXPECT_EQ(upper.points(), 1u);
  EXPECT_EQ(upper.lowest(aside, upper.base(aside), 1, 6.0), 0.5 * 1.0 + 0.5 * 10.0);
}

TEST(AlphaPolicy, ComesBackFromItsFile) {
  const ExactModel model = make_tiger_with_horizon(4);
  const AlphaPolicy policy = solve(model, 1e-6).alpha;
  std::stringstream file;
  write_policy(file, model, policy);
  const AlphaPolicy back = read_policy(file, model);
  expect_equal(back, policy);
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
