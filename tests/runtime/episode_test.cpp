// SPDX-License-Identifier: Apache-2.0
#include "hypgen/episode/episode.hpp"

#include <gtest/gtest.h>

#include "factored_models.hpp"
#include "hypgen/belief/particle_belief.hpp"
#include "test_solvers.hpp"

namespace hypgen::testing {
namespace {

EpisodeRecord run(const ModelDescriptor& model, int steps, std::vector<StepRecord>* records = nullptr,
                  Mode mode = Mode::kDespot, bool interrupted = false, std::uint64_t episode = 0) {
  PlannerOptions options = trials(20);
  options.mode = mode;
  Solver solver(model, options);
  const EpisodeLimits limits{steps, model.discount, [=] { return interrupted; }};
  return run_episode(solver.planner, *solver.belief, *solver.world, model.visible_count, episode, limits,
                     [&](const StepRecord& step) {
                       if (records != nullptr) records->push_back(step);
                     });
}

TEST(Episode, AddsUpDiscountedRewards) {
  std::vector<StepRecord> records;
  const EpisodeRecord episode = run(rock_sample_descriptor<4, 3>(), 50, &records);
  EXPECT_EQ(episode.status, Status::kTerminal);
  EXPECT_TRUE(episode.success);
  ASSERT_EQ(static_cast<std::size_t>(episode.steps), records.size());
  double total = 0.0, weight = 1.0;
  for (const StepRecord& record : records) {
    total += weight * record.reward;
    weight *= 0.95;
  }
  EXPECT_NEAR(episode.discounted_return, total, 1e-9);
  EXPECT_TRUE(records.back().terminal);
}

TEST(Episode, PairsWorldsAcrossModes) {
  std::vector<StepRecord> search, policy;
  run(tiger_descriptor(), 3, &search, Mode::kDespot, false, 5);
  run(tiger_descriptor(), 3, &policy, Mode::kDefault, false, 5);
  EXPECT_EQ(search[0].decision.action, policy[0].decision.action);
  EXPECT_EQ(search[0].observation, policy[0].observation);
}

TEST(Episode, APlanHasWhatTheUpdateLeavesOfAPeriod) {
  EXPECT_DOUBLE_EQ(rest_of_period(0.1, 0.03), 0.1 - 0.03);
  EXPECT_GT(rest_of_period(0.1, 0.2), 0.0);
  EXPECT_LT(rest_of_period(0.1, 0.2), 1e-5);
  Solver solver(tiger_descriptor(), {});
  EpisodeLimits limits{4, 0.95, [] { return false; }};
  limits.period = 0.01;
  std::vector<StepRecord> records;
  run_episode(solver.planner, *solver.belief, *solver.world, tiger_descriptor().visible_count, 0, limits,
              [&](const StepRecord& step) { records.push_back(step); });
  ASSERT_EQ(records.size(), 4U);
  double before = 0.0;
  for (const StepRecord& record : records) {
    EXPECT_DOUBLE_EQ(record.cycle_seconds, before + record.decision.search_seconds);
    EXPECT_NE(record.decision.status, Status::kTrialLimit);
    before = record.update_seconds;
  }
}

TEST(Episode, EndsWithANamedStatus) {
  EXPECT_EQ(run(tiger_descriptor(), 4).status, Status::kStepLimit);
  EXPECT_EQ(run(mishaps_descriptor(9.0, 9), 5).status, Status::kTerminal);
  EXPECT_EQ(run(mishaps_descriptor(9.0, 2), 5).status, Status::kNoLegalAction);
  EXPECT_EQ(run(tiger_descriptor(), 4, nullptr, Mode::kDespot, true).status, Status::kInterrupted);
}

// A world that shows a key which no coin and level explain.
class OddWorld final : public World {
 public:
  void reset(std::uint64_t) override {}
  void set_start(StartValues) override {}
  void export_visible(std::int32_t* out) const override { out[0] = 25; }
  void export_state(std::int32_t*) const override {}
  bool is_legal(int) const override { return true; }
  WorldStep step(int) override { return {}; }
};

TEST(Episode, EndsAtAStartThatNothingExplainsIfItIsToldTo) {
  const CoinSeenFirst::Params params;
  ParticleBelief<CoinSeenFirst> belief(params, 0, 100);
  Solver solver(tiger_descriptor(), trials(1));
  OddWorld world;
  EpisodeLimits limits{5, 0.9, [] { return false; }, true};
  StartRecord start;
  const EpisodeRecord episode = run_episode(
      solver.planner, belief, world, 1, 3, limits, [](const StepRecord&) { FAIL(); },
      [&](const StartRecord& record) { start = record; });
  EXPECT_EQ(episode.status, Status::kImpossibleObservation);
  EXPECT_EQ(episode.steps, 0);
  EXPECT_EQ(start.episode, 3U);
  EXPECT_EQ(start.visible, std::vector<std::int32_t>{25});
  EXPECT_EQ(start.belief_status, Status::kImpossibleObservation);
}

TEST(Episode, StatusesHaveNames) {
  EXPECT_STREQ(status_name(Status::kDepletedBelief), "depleted_belief");
  for (int i = 0; i <= static_cast<int>(Status::kInterrupted); ++i) {
    EXPECT_STRNE(status_name(static_cast<Status>(i)), "unknown");
  }
}

}  // namespace
}  // namespace hypgen::testing
