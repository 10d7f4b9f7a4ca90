// SPDX-License-Identifier: Apache-2.0
#include "hypgen/search/planner.hpp"

#include <gtest/gtest.h>
#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <limits>
#include <thread>
#include <vector>

#include "test_solvers.hpp"

namespace hypgen::testing {
namespace {

TEST(Planner, TigerListensFirst) {
  Solver solver(tiger_descriptor(), trials(2000));
  const Decision decision = solver.plan();
  EXPECT_EQ(decision.action, 0);
  EXPECT_EQ(decision.status, Status::kTrialLimit);
  EXPECT_EQ(decision.trials, 2000U);
  // The initial belief is worth about 19.4. So few scenarios make the lower bound optimistic, as their
  // futures can be told apart, but never less than always listening.
  EXPECT_GT(decision.upper, 19.4);
  EXPECT_GT(decision.lower, -20.0);
  EXPECT_LE(decision.lower, decision.upper);
}

TEST(Planner, TigerOpensOnceItIsSure) {
  Solver solver(tiger_descriptor(), trials(500));
  for (int i = 0; i < 3; ++i) ASSERT_EQ(solver.see(0, 0), Status::kOk);
  EXPECT_EQ(solver.plan(3).action, 2);  // the tiger is on the left
}

TEST(Planner, BoundsAreOrderedAndTightenWithTrials) {
  double gap = 1e9;
  for (const std::uint64_t count : {1, 10, 100, 1000}) {
    Solver solver(rock_sample_descriptor<4, 3>(), trials(count));
    const Decision decision = solver.plan();
    EXPECT_LE(decision.lower, decision.upper);
    EXPECT_LE(decision.upper - decision.lower, gap + 1e-9);
    gap = decision.upper - decision.lower;
  }
}

TEST(Planner, TrialLimitsAreReproducible) {
  PlannerOptions options = trials(200);
  options.signature = true;
  Solver first(rock_sample_descriptor<4, 3>(), options), second(rock_sample_descriptor<4, 3>(), options);
  const Decision a = first.plan();
  second.plan();
  const Decision b = second.plan();  // the planner's past does not matter
  EXPECT_EQ(a.signature, b.signature);
  EXPECT_EQ(a.action, b.action);
  EXPECT_NE(a.signature, 0U);
  options.seed = 1;
  Solver other(rock_sample_descriptor<4, 3>(), options);
  EXPECT_NE(other.plan().signature, a.signature);
}

TEST(Planner, ConvergesOnASmallProblem) {
  PlannerOptions options = trials(1000000);
  options.depth = 4;
  Solver solver(tiger_descriptor(), options);
  const Decision decision = solver.plan();
  EXPECT_EQ(decision.status, Status::kConverged);
  EXPECT_LT(decision.upper - decision.lower, 1e-3);
}

// What a thread has used of the processor, which other processes do not prolong.
double processor_seconds(clockid_t clock) {
  timespec time;
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

TEST(Planner, KeepsTheDeadline) {
  PlannerOptions options;
  options.time_limit = 0.02;
  options.memory_bytes = std::size_t{256} << 20;
  clockid_t mine;
  ASSERT_EQ(pthread_getcpuclockid(pthread_self(), &mine), 0);
  for (const Mode mode : {Mode::kDespot, Mode::kRollout}) {
    options.mode = mode;
    Solver solver(rock_sample_descriptor<7, 8>(), options);
    std::vector<double> after;  // the deadline, for each search
    for (int i = 0; i < 21; ++i) {
      const auto deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(20);
      double before = 0.0;
      std::thread watch([&] {
        std::this_thread::sleep_until(deadline);
        before = processor_seconds(mine);
      });
      const Decision decision = solver.planner.plan(*solver.belief, 0, i);
      const double all = processor_seconds(mine);
      watch.join();
      after.push_back(all - before);
      EXPECT_EQ(decision.status, Status::kDeadline);
      EXPECT_GE(decision.search_seconds, 0.01);  // half of it, where pauses are expected
    }
    std::sort(after.begin(), after.end());
    EXPECT_LT(after[after.size() / 2], 0.001);
  }
}

// Hands all calls on, and counts the roots of which some action would have a floor for its lower bound.
class RootWatcher final : public LeafEvaluator {
 public:
  RootWatcher(std::unique_ptr<LeafEvaluator> inner, int& roots, int& with_floors)
      : inner_(std::move(inner)), roots_(roots), with_floors_(with_floors) {}

  RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) override {
    return inner_->begin_search(root, setup);
  }
  std::size_t submit(std::size_t thread, Span<const LeafRequest> requests) override {
    for (const LeafRequest& request : requests) {
      if (request.parent != kNoHandle) continue;
      ++roots_;
      if (request.rolled < request.actions.size()) ++with_floors_;
    }
    return inner_->submit(thread, requests);
  }
  bool poll(std::size_t thread, LeafResult& result) override { return inner_->poll(thread, result); }
  void release() override { inner_->release(); }

 private:
  std::unique_ptr<LeafEvaluator> inner_;
  int& roots_;
  int& with_floors_;
};

// A tree's gain counts from the root's expansion. From a floor it would count all that the policy earns.
TEST(Planner, ATreeStartsFromRolloutsOfAllSurvivors) {
  PlannerOptions options = trials(UINT64_MAX);
  options.time_limit = 0.1;
  options.rolled = 1;
  options.rolled_at_root = 2;
  const Solver solver(rock_sample_descriptor<4, 3>(), options);
  int roots = 0, with_floors = 0;
  auto inner = solver.instance->make_evaluator(evaluator_options(options, solver.model));
  Planner planner(std::make_unique<RootWatcher>(std::move(inner), roots, with_floors), solver.model, options);
  planner.prepare(*solver.belief);
  // Other processes may hold the processor until a plan's time is over.
  Looked looked = Looked::kNowhere;
  for (int step = 0; step < 50 && (looked != Looked::kTree || roots < 2); ++step) {
    looked = planner.plan(*solver.belief, 0, step).looked;
  }
  EXPECT_EQ(looked, Looked::kTree);
  EXPECT_GT(roots, 1);
  EXPECT_EQ(with_floors, 0);
}

TEST(Planner, ATrialLimitEndsAPlanThatHasTooFewScenariosForATree) {
  PlannerOptions options = trials(2);
  options.time_limit = 3600.0;
  options.scenarios = 1;
  Solver solver(rock_sample_descriptor<4, 3>(), options);
  const Decision decision = solver.plan();
  EXPECT_EQ(decision.status, Status::kTrialLimit);
  EXPECT_EQ(decision.trials, 2U);
}

TEST(Planner, ATinyDeadlineGivesTheDefaultAction) {
  PlannerOptions options;
  options.time_limit = 1e-9;
  Solver solver(rock_sample_descriptor<7, 8>(), options);
  const Decision decision = solver.plan();
  EXPECT_EQ(decision.status, Status::kDeadline);
  EXPECT_EQ(decision.action, SmallRockSample::kEast);
}

TEST(Planner, StopsGrowingWhenMemoryIsFull) {
  PlannerOptions options = trials(100000);
  options.memory_bytes = 40000;
  Solver solver(rock_sample_descriptor<4, 3>(), options);
  const Decision decision = solver.plan();
  EXPECT_EQ(decision.status, Status::kMemoryFull);
  EXPECT_GT(decision.expansions, 0U);
  EXPECT_GE(decision.action, 0);
}

TEST(Planner, PruningGivesSmallerTrees) {
  PlannerOptions options = trials(300);
  Solver plain(rock_sample_descriptor<4, 3>(), options);
  options.pruning = 1.0;
  Solver pruned(rock_sample_descriptor<4, 3>(), options);
  const Decision a = plain.plan(), b = pruned.plan();
  EXPECT_LT(b.nodes, a.nodes);
  EXPECT_LE(b.lower, b.upper);
}

TEST(Planner, DefaultModeFollowsThePolicy) {
  PlannerOptions options = trials(10);
  options.mode = Mode::kDefault;
  Solver solver(rock_sample_descriptor<4, 3>(), options);
  const Decision decision = solver.plan();
  EXPECT_EQ(decision.status, Status::kOk);
  EXPECT_EQ(decision.action, SmallRockSample::kEast);
  EXPECT_EQ(decision.expansions, 0U);
}

TEST(Planner, RolloutModeLeavesThePolicyForASureGain) {
  PlannerOptions options = trials(20);
  options.mode = Mode::kRollout;
  Solver solver(tiger_descriptor(), options);
  EXPECT_EQ(solver.plan().action, 0);  // opening either door loses
  for (int i = 0; i < 5; ++i) solver.see(0, 1);
  const Decision decision = solver.plan(5);
  EXPECT_EQ(decision.action, 1);
  EXPECT_EQ(decision.status, Status::kTrialLimit);
  EXPECT_EQ(decision.trials, 20U);
}

TEST(Planner, ThreadsThatShareAComparisonFindTheSame) {
  PlannerOptions options = trials(4);
  options.mode = Mode::kRollout;
  for (options.seed = 0; options.seed < 5; ++options.seed) {
    options.threads = 1;
    const Decision alone = Solver(rock_sample_descriptor<4, 3>(), options).plan();
    for (const std::size_t threads : {2, 3, 16}) {
      options.threads = threads;
      const Decision shared = Solver(rock_sample_descriptor<4, 3>(), options).plan();
      EXPECT_EQ(shared.action, alone.action);
      EXPECT_EQ(shared.expansions, alone.expansions);
      EXPECT_EQ(shared.simulations, alone.simulations);
      EXPECT_EQ(shared.children, alone.children);
    }
  }
}

TEST(Planner, TimedRolloutsComeInBatchesThatFit) {
  PlannerOptions options;
  options.mode = Mode::kRollout;
  options.time_limit = 0.05;
  Solver solver(tiger_descriptor(), options);
  Decision decision;
  // Other processes may hold the processor until a plan's time is over.
  for (int step = 0; step < 50 && decision.trials <= 2; ++step) decision = solver.plan(step);
  EXPECT_EQ(decision.action, 0);
  EXPECT_EQ(decision.status, Status::kDeadline);
  EXPECT_GT(decision.trials, 2U);
  EXPECT_LE(decision.leaf_scenarios, decision.trials * options.scenarios);
}

TEST(Planner, ReportsWhatIsWrongWithAModel) {
  Solver nan(mishaps_descriptor(std::numeric_limits<double>::quiet_NaN(), 9), trials(10));
  EXPECT_EQ(nan.plan().status, Status::kModelNan);
  EXPECT_EQ(nan.plan().action, 0);
  Solver crossed(mishaps_descriptor(-1.0, 9), trials(10));
  EXPECT_EQ(crossed.plan().status, Status::kCrossedBounds);
  Solver stuck(mishaps_descriptor(9.0, 0), trials(10));
  EXPECT_EQ(stuck.plan().status, Status::kNoLegalAction);
  EXPECT_EQ(stuck.plan().action, -1);
}

TEST(Planner, FindsTheBestPathToTheEnd) {
  Solver solver(mishaps_descriptor(9.0, 9), trials(100));
  const Decision decision = solver.plan();
  EXPECT_EQ(decision.action, 1);
  EXPECT_EQ(decision.status, Status::kConverged);
  EXPECT_DOUBLE_EQ(decision.lower, 3.0);
  EXPECT_DOUBLE_EQ(decision.upper, 3.0);
}

// An evaluator that gives nothing back.
class BrokenEvaluator final : public LeafEvaluator {
 public:
  RootResult begin_search(const ScenarioBuffer& root, const SearchSetup&) override {
    return {Status::kOk, empty_row(0, static_cast<std::uint32_t>(root.size()), false), 0};
  }
  std::size_t submit(std::size_t, Span<const LeafRequest>) override { return 1; }
  bool poll(std::size_t, LeafResult&) override { return false; }
  void release() override {}
};

TEST(Planner, SurvivesABrokenEvaluator) {
  PlannerOptions options = trials(10);
  options.patience = 0.01;
  const Solver solver(tiger_descriptor(), options);
  Planner planner(std::make_unique<BrokenEvaluator>(), solver.model, options);
  planner.prepare(*solver.belief);
  const Decision decision = planner.plan(*solver.belief, 0, 0);
  EXPECT_EQ(decision.status, Status::kEvaluatorFailed);
  EXPECT_EQ(decision.action, 0);
}

}  // namespace
}  // namespace hypgen::testing
