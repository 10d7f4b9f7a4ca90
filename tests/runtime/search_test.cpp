// SPDX-License-Identifier: Apache-2.0
#include "hypgen/search/search.hpp"

#include <gtest/gtest.h>

#include "hypgen/search/tree_check.hpp"
#include "mock_evaluator.hpp"
#include "test_solvers.hpp"

namespace hypgen::testing {
namespace {

PlannerOptions flying(std::size_t in_flight, std::uint64_t count = 300) {
  PlannerOptions options = trials(count);
  options.in_flight = in_flight;
  options.signature = true;
  return options;
}

// Plans for RockSample with a mock between the planner and the CPU's evaluator.
Decision plan(const PlannerOptions& options, const Mischief& mischief) {
  const Solver solver(rock_sample_descriptor<4, 3>(), options);
  auto inner = solver.instance->make_evaluator(evaluator_options(options, solver.model));
  Planner planner(std::make_unique<MockEvaluator>(std::move(inner), mischief), solver.model, options);
  planner.prepare(*solver.belief);
  return checked_plan(planner, *solver.belief, 0);
}

TEST(Search, LatencyDoesNotChangeTheTree) {
  for (const std::size_t in_flight : {1, 2, 7, 64}) {
    const PlannerOptions options = flying(in_flight);
    Solver solver(rock_sample_descriptor<4, 3>(), options);
    const Decision wanted = solver.plan();
    EXPECT_EQ(wanted.status, Status::kTrialLimit);
    EXPECT_EQ(wanted.trials, 300U);
    for (unsigned seed = 0; seed < 4; ++seed) {
      const Decision decision = plan(options, {seed});
      EXPECT_EQ(decision.signature, wanted.signature) << in_flight << " in flight, seed " << seed;
      EXPECT_EQ(decision.action, wanted.action);
      EXPECT_EQ(decision.trials, wanted.trials);
      EXPECT_EQ(decision.expansions, wanted.expansions);
    }
  }
}

TEST(Search, TrialsInFlightSpread) {
  Solver one(rock_sample_descriptor<7, 8>(), flying(1)), many(rock_sample_descriptor<7, 8>(), flying(16));
  const Decision a = one.plan(), b = many.plan();
  EXPECT_NE(a.signature, b.signature);
  EXPECT_GT(b.expansions, a.expansions / 2);
  EXPECT_LE(b.lower, b.upper);
}

TEST(Search, ExplorationMakesAnotherTreeTheSameEachTime) {
  PlannerOptions options = flying(16);
  Solver plain(rock_sample_descriptor<4, 3>(), options);
  options.exploration = 0.5;
  Solver first(rock_sample_descriptor<4, 3>(), options), second(rock_sample_descriptor<4, 3>(), options);
  const Decision decision = first.plan();
  EXPECT_EQ(decision.signature, second.plan().signature);
  EXPECT_NE(decision.signature, plain.plan().signature);
}

TEST(Search, ConvergesToTheSameValue) {
  for (const auto& [in_flight, exploration] :
       {std::pair<std::size_t, double>{1, 0.0}, {2, 0.0}, {7, 0.0}, {64, 0.0}, {1, 0.5}, {64, 0.5}}) {
    PlannerOptions options = flying(in_flight, 1000000);
    options.exploration = exploration;
    options.depth = 4;
    options.gap = 1e-9;
    Solver solver(tiger_descriptor(), options);
    const Decision decision = solver.plan();
    EXPECT_EQ(decision.status, Status::kConverged);
    options.in_flight = 1;
    options.exploration = 0.0;
    Solver single(tiger_descriptor(), options);
    EXPECT_NEAR(decision.lower, single.plan().lower, 1e-6);
  }
}

TEST(Search, FailuresEndItWithALegalAction) {
  for (const std::size_t in_flight : {1, 7, 64}) {
    for (const Status status :
         {Status::kModelNan, Status::kMemoryFull, Status::kDeviceLost, Status::kDeadline}) {
      const Decision decision = plan(flying(in_flight), {3, 20, status});
      EXPECT_EQ(decision.status, status);
      EXPECT_EQ(decision.expansions, 20U);
      EXPECT_GE(decision.action, 0);
      EXPECT_LE(decision.lower, decision.upper);
    }
  }
}

TEST(Search, ALostDeviceIsToldBeforeCrossedBounds) {
  const PlannerOptions options = trials(10);
  const Solver solver(mishaps_descriptor(-1.0, 9), options);
  auto inner = solver.instance->make_evaluator(evaluator_options(options, solver.model));
  Planner planner(std::make_unique<MockEvaluator>(std::move(inner), Mischief{1, 0, Status::kDeviceLost}),
                  solver.model, options);
  planner.prepare(*solver.belief);
  EXPECT_EQ(planner.plan(*solver.belief, 0, 0).status, Status::kDeviceLost);
}

TEST(Search, SilenceEndsAtTheDeadline) {
  for (const std::uint64_t leaves : {0, 1, 100}) {
    PlannerOptions options = flying(7);
    options.time_limit = 0.02;
    const Decision decision = plan(options, {5, leaves, Status::kOk, true});
    EXPECT_EQ(decision.status, Status::kDeadline);
    EXPECT_GE(decision.action, 0);
    EXPECT_LT(decision.search_seconds, 0.5);
    options.time_limit = std::numeric_limits<double>::infinity();
    options.patience = 0.01;
    EXPECT_EQ(plan(options, {5, leaves, Status::kOk, true}).status, Status::kEvaluatorFailed);
  }
}

TEST(Search, TakesNoLeafAfterTheDeadline) {
  const PlannerOptions options = flying(7);
  const Solver solver(rock_sample_descriptor<4, 3>(), options);
  const auto evaluator = solver.instance->make_evaluator(evaluator_options(options, solver.model));
  ScenarioBuffer scenarios;
  solver.belief->reserve(scenarios, options.scenarios);
  SearchSetup setup{derive(0, StreamKind::kPlan, 0), options.depth, false, Clock::time_point::max()};
  solver.belief->sample(setup.key, 0, options.scenarios, scenarios);
  const RootResult root = evaluator->begin_search(scenarios, setup);  // it does not look at the clock
  setup.deadline = Clock::now();
  Search search(options, {options.memory_bytes, options.depth, 0.95, 0.0});
  Decision decision;
  search.run(*evaluator, root, setup, {}, decision);
  EXPECT_EQ(decision.status, Status::kDeadline);
  EXPECT_EQ(decision.expansions, 0U);
}

TEST(Search, BoundsAreSumsOfThoseBelow) {
  for (const std::size_t in_flight : {1, 7, 64}) {
    for (const auto& [pruning, exploration] : {std::pair{0.0, 0.0}, {0.1, 0.0}, {0.0, 0.5}, {0.1, 0.5}}) {
      PlannerOptions options = flying(in_flight, 1000);
      options.pruning = pruning;
      options.exploration = exploration;
      options.memory_bytes = std::size_t{256} << 20;
      const Solver solver(rock_sample_descriptor<4, 3>(), options);
      const auto evaluator = solver.instance->make_evaluator(evaluator_options(options, solver.model));
      ScenarioBuffer scenarios;
      solver.belief->reserve(scenarios, options.scenarios);
      const SearchSetup setup{derive(0, StreamKind::kPlan, 0), options.depth, false,
                              Clock::time_point::max()};
      solver.belief->sample(setup.key, 0, options.scenarios, scenarios);
      Search search(options, {options.memory_bytes, options.depth, 0.95, pruning, 1, exploration > 0.0});
      Decision decision;
      search.run(*evaluator, evaluator->begin_search(scenarios, setup), setup, {}, decision);
      EXPECT_EQ(decision.status, Status::kTrialLimit);
      EXPECT_EQ(tree_fault(search.tree(), false), "");
    }
  }
}

}  // namespace
}  // namespace hypgen::testing
