// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "test_solvers.hpp"

namespace hypgen::testing {
namespace {

PlannerOptions by_values(std::uint64_t count, std::size_t in_flight = 1) {
  PlannerOptions options = trials(count);
  options.mode = Mode::kPomcp;
  options.exploration = 0.2;
  options.in_flight = in_flight;
  options.signature = true;
  return options;
}

// What the actions at the root are worth by the last plan.
double value(const Solver& solver, std::uint32_t action) {
  return solver.planner.tree().mean_value(solver.planner.tree().root(), action);
}

// The value of Tiger with so many steps to go, and listening for ever after them (-20). The belief is how
// many more times the tiger was heard on one side; unlimited it is worth 19.37.
double exact_value(int steps, int heard) {
  if (steps == 0) return -20.0;
  const double discount = 0.95, hearing = 0.85;
  const double odds = std::pow(hearing / (1.0 - hearing), heard), sure = odds / (1.0 + odds);
  const double again = sure * hearing + (1.0 - sure) * (1.0 - hearing);
  const double listens = -1.0 + discount * (again * exact_value(steps - 1, heard + 1) +
                                            (1.0 - again) * exact_value(steps - 1, heard - 1));
  const double likely = std::max(sure, 1.0 - sure);
  const double opens = 10.0 * likely - 100.0 * (1.0 - likely) + discount * exact_value(steps - 1, 0);
  return std::max(listens, opens);
}

TEST(Pomcp, TigerIsWorthWhatItIs) {
  PlannerOptions options = by_values(20000);
  options.exploration = 0.05;
  options.depth = 8;
  options.scenarios = 16000;  // so that many are left where a trial ends: few could be told apart
  Solver solver(tiger_descriptor(), options, 16000);
  const Decision decision = solver.plan();
  EXPECT_EQ(decision.action, 0);
  EXPECT_EQ(decision.status, Status::kTrialLimit);
  EXPECT_EQ(decision.trials, 20000U);
  EXPECT_NEAR(value(solver, 0), exact_value(options.depth, 0), 0.7);
  EXPECT_NEAR(value(solver, 1), -45.0 - 0.95 * 20.0, 1.5);  // as if it listened for ever
  EXPECT_FALSE(decision.lower > decision.upper);
}

TEST(Pomcp, HasAsManyScenariosAsTheTimeAllows) {
  PlannerOptions options;
  options.mode = Mode::kPomcp;
  options.scenarios = 100'000;  // the root's actions alone would take longer
  options.time_limit = 0.02;
  Solver solver(tiger_descriptor(), options);
  Decision decision;
  // Other processes may hold the processor until a plan's time is over.
  for (int step = 0; step < 50 && decision.looked != Looked::kTree; ++step) decision = solver.plan(step);
  EXPECT_EQ(decision.looked, Looked::kTree);
  EXPECT_EQ(decision.status, Status::kDeadline);
  EXPECT_GT(decision.scenarios, 0U);
  EXPECT_LT(decision.scenarios, options.scenarios);
  EXPECT_GT(decision.trials, 1U);
}

TEST(Pomcp, OpensOnceItIsSure) {
  Solver solver(tiger_descriptor(), by_values(500));
  for (int i = 0; i < 3; ++i) ASSERT_EQ(solver.see(0, 0), Status::kOk);
  EXPECT_EQ(solver.plan(3).action, 2);
}

TEST(Pomcp, TrialLimitsAreReproducible) {
  for (const std::size_t in_flight : {1, 16}) {
    const PlannerOptions options = by_values(300, in_flight);
    Solver first(rock_sample_descriptor<4, 3>(), options), second(rock_sample_descriptor<4, 3>(), options);
    const Decision decision = first.plan();
    second.plan();
    EXPECT_EQ(decision.signature, second.plan().signature);
    EXPECT_NE(decision.signature, first.plan(1).signature);
    EXPECT_EQ(decision.trials, 300U);
  }
}

TEST(Pomcp, TakesOneActionForEachTrial) {
  Solver solver(rock_sample_descriptor<4, 3>(), by_values(1000, 7));
  solver.plan();
  const Node& root = solver.planner.tree().root();
  std::uint64_t visits = 1;  // of the root's expansion
  for (std::uint32_t a = 0; a < root.expanded()->action_count; ++a) {
    const ActionTable* const table = solver.planner.tree().table(*root.expanded(), a);
    visits += table == nullptr ? 0 : table->visits.load();
  }
  EXPECT_EQ(root.child->visits(), 1001U);
  EXPECT_EQ(visits, 1001U);
}

TEST(Pomcp, ReportsWhatIsWrongWithAModel) {
  for (const std::size_t in_flight : {1, 16}) {
    Solver nan(mishaps_descriptor(std::numeric_limits<double>::quiet_NaN(), 9), by_values(10, in_flight));
    EXPECT_EQ(nan.plan().status, Status::kModelNan);
    Solver stuck(mishaps_descriptor(9.0, 0), by_values(10, in_flight));
    EXPECT_EQ(stuck.plan().status, Status::kNoLegalAction);
    Solver solver(mishaps_descriptor(9.0, 9), by_values(100, in_flight));
    EXPECT_EQ(solver.plan().action, 1);
  }
}

TEST(Pomcp, StopsGrowingWhenMemoryIsFull) {
  PlannerOptions options = by_values(100000);
  options.memory_bytes = 40000;
  Solver solver(rock_sample_descriptor<4, 3>(), options);
  const Decision decision = solver.plan();
  EXPECT_EQ(decision.status, Status::kMemoryFull);
  EXPECT_GE(decision.action, 0);
}

}  // namespace
}  // namespace hypgen::testing
