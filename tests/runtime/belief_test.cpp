// SPDX-License-Identifier: Apache-2.0
#include "hypgen/belief/belief.hpp"

#include <gtest/gtest.h>

#include "test_solvers.hpp"

namespace hypgen::testing {
namespace {

TEST(Belief, FollowsTheExactTigerPosterior) {
  Solver solver(tiger_descriptor(), trials(1), 20000);
  const double hearing = static_cast<double>(0.85F);
  double left = solver.belief->marginal(0, 0);
  EXPECT_NEAR(left, 0.5, 0.02);
  for (const std::uint64_t heard : {0U, 0U, 1U, 0U}) {
    ASSERT_EQ(solver.see(0, heard), Status::kOk);
    const double right = (1.0 - left) * (heard == 1 ? hearing : 1.0 - hearing);
    left *= heard == 0 ? hearing : 1.0 - hearing;
    left /= left + right;
    EXPECT_NEAR(solver.belief->marginal(0, 0), left, 1e-3);
  }
  ASSERT_EQ(solver.see(1, 0), Status::kOk);  // opening a door starts again
  EXPECT_NEAR(solver.belief->marginal(0, 0), 0.5, 0.02);
}

TEST(Belief, GivesEachValueWithItsWeight) {
  Solver solver(tiger_descriptor(), trials(1), 1000);
  solver.see(0, 0);
  double left = 0.0, all = 0.0;
  solver.belief->each_value(0, [&](std::int32_t value, double weight) {
    left += value == 0 ? weight : 0.0;
    all += weight;
  });
  EXPECT_NEAR(all, 1.0, 1e-12);
  EXPECT_DOUBLE_EQ(left, solver.belief->marginal(0, 0));
}

TEST(Belief, ResamplesBeforeWeightsDegenerate) {
  Solver solver(tiger_descriptor(), trials(1), 1000);
  EXPECT_NEAR(solver.belief->effective_sample_size(), 1000.0, 1e-6);
  for (int i = 0; i < 6; ++i) {
    solver.see(0, 1);
    EXPECT_GE(solver.belief->effective_sample_size(), 499.0);
  }
}

TEST(Belief, SamplesInProportionToWeights) {
  Solver solver(tiger_descriptor(), trials(1), 1000);
  solver.see(0, 0);
  ScenarioBuffer scenarios;
  solver.belief->reserve(scenarios, 200);
  solver.belief->sample(derive(0, StreamKind::kPlan, 0), 0, 200, scenarios);
  ASSERT_EQ(scenarios.size(), 200U);
  std::vector<Tiger::Fixed> fixed(200);
  std::vector<Tiger::State> states(200);
  scenarios.copy_to(fixed.data(), states.data());
  int left = 0;
  for (const Tiger::State& state : states) left += state.words[0] == 0;
  EXPECT_NEAR(left / 200.0, solver.belief->marginal(0, 0), 0.02);
}

TEST(Belief, ParticlesCanBeMovedToAnotherBelief) {
  Solver from(tiger_descriptor(), trials(1), 100), to(tiger_descriptor(), trials(1), 100);
  from.see(0, 0);
  ScenarioBuffer particles;
  std::vector<double> weights;
  from.belief->reserve(particles, from.belief->size());
  from.belief->export_particles(particles, weights);
  ASSERT_TRUE(to.belief->import_particles(particles, weights));
  EXPECT_DOUBLE_EQ(to.belief->marginal(0, 0), from.belief->marginal(0, 0));
  weights.pop_back();
  EXPECT_FALSE(to.belief->import_particles(particles, weights));
}

TEST(Belief, TellsFailuresApart) {
  Solver tiger(tiger_descriptor(), trials(1), 100);
  EXPECT_EQ(tiger.see(0, 7), Status::kImpossibleObservation);
  EXPECT_NEAR(tiger.belief->effective_sample_size(), 100.0, 1e-9);  // it stays as it was

  Solver counter(mishaps_descriptor(9.0, 9), trials(1), 100);
  EXPECT_EQ(counter.see(0, 1), Status::kOk);
  EXPECT_EQ(counter.see(0, 0), Status::kDepletedBelief);  // only hidden = 1 is left
  EXPECT_EQ(counter.see(0, 1), Status::kOk);
  EXPECT_EQ(counter.see(0, 1), Status::kAllParticlesTerminal);
}

TEST(Belief, GoesOnFromWhatItCannotExplain) {
  Solver counter(mishaps_descriptor(9.0, 9), trials(1), 100);
  EXPECT_EQ(counter.see(0, 1), Status::kOk);
  EXPECT_EQ(counter.see(0, 0), Status::kDepletedBelief);
  counter.belief->propagate(0, words_of(0));
  EXPECT_DOUBLE_EQ(counter.belief->marginal(0, 2), 1.0);  // what is visible moves on
  EXPECT_DOUBLE_EQ(counter.belief->marginal(1, 1), 1.0);
  EXPECT_EQ(counter.see(0, 1), Status::kAllParticlesTerminal);
  counter.belief->propagate(0, words_of(1));
  EXPECT_DOUBLE_EQ(counter.belief->marginal(0, 3), 1.0);
  EXPECT_EQ(counter.see(0, 1), Status::kOk);
}

}  // namespace
}  // namespace hypgen::testing
