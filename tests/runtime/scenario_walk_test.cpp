// SPDX-License-Identifier: Apache-2.0
// The walk of a tree's scenarios against the leaves that an evaluator has expanded.
#include "hypgen/leaves/scenario_walk.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "test_solvers.hpp"

namespace hypgen::testing {
namespace {

using Model = SmallRockSample;

class ScenarioWalkTest : public ::testing::TestWithParam<bool> {
 protected:
  ScenarioWalkTest() : solver_(rock_sample_descriptor<4, 3>(), trials(1)) {
    setup_.weighted = GetParam();
    solver_.belief->reserve(scenarios_, kScenarios);
    solver_.belief->sample(setup_.key, 5, kScenarios, scenarios_);
    EvaluatorOptions options{kScenarios, std::size_t{1} << 24, 0.95, 20};
    options.may_weigh = true;
    evaluator_ = solver_.instance->make_evaluator(options);
    evaluator_->begin_search(scenarios_, setup_);
  }

  struct Leaf {
    std::uint64_t handle;
    std::vector<ActionRow> actions;
    std::vector<ChildRow> children;

    const ActionRow* action(int wanted) const {
      for (const ActionRow& row : actions)
        if (row.action == wanted) return &row;
      return nullptr;
    }
    std::vector<ChildRow> groups(int wanted) const {
      const ActionRow* const row = action(wanted);
      if (row == nullptr) return {};
      const auto first = children.begin() + row->first_child;
      return {first, first + row->child_count};
    }
  };

  Leaf expand(const LeafRequest& request) {
    LeafResult found{};
    EXPECT_EQ(evaluator_->submit(0, {&request, 1}), 1U);
    EXPECT_TRUE(evaluator_->poll(0, found));
    EXPECT_EQ(found.status, Status::kOk);
    return {found.handle,
            {found.actions.begin(), found.actions.end()},
            {found.children.begin(), found.children.end()}};
  }

  // The rewards of an action over the members where the walk is, as the rows of a leaf have them.
  std::int64_t reward_sum(const ModelWalk<Model>& walk, const Model::Params& params, int action, int depth,
                          std::uint32_t count) {
    WideSum sum = 0;
    for (std::uint32_t i = 0; i < walk.members().size(); ++i) {
      const CpuMember<Model>& member = walk.members()[i];
      PhiloxDraws draws(setup_.key, scenarios_.first() + (setup_.weighted ? i : member.scenario),
                        static_cast<std::uint32_t>(depth));
      Model::State next;
      sum += Model::step(params, {}, member.state, action, draws, next).reward;
    }
    return setup_.weighted ? spread(sum, count, walk.members().size()) : static_cast<std::int64_t>(sum);
  }

  static constexpr std::uint32_t kScenarios = 40;
  Solver solver_;
  ScenarioBuffer scenarios_;
  SearchSetup setup_{derive(0, StreamKind::kPlan, 0), 20, false, Clock::time_point::max()};
  std::unique_ptr<LeafEvaluator> evaluator_;
};

// Checks a rock, goes to it and samples it: what that earns tells which members each node has.
TEST_P(ScenarioWalkTest, MeetsTheMembersThatLeavesHave) {
  const auto& params = *static_cast<const Model::Params*>(solver_.instance->params());
  ModelWalk<Model> walk(params, scenarios_, setup_.key, setup_.weighted);
  const std::uint32_t whole = kScenarios * (setup_.weighted ? kScenarioMass : 1);
  const Leaf root = expand({0, kNoHandle, 0, 0, whole, 0, {}});
  int sampled = 0;
  std::int64_t earned = 0;
  const auto follow = [&](const auto& self, const Leaf& leaf, std::uint32_t count, int depth) -> void {
    for (const ActionRow& row : leaf.actions)
      EXPECT_EQ(row.reward_sum, reward_sum(walk, params, row.action, depth, count)) << row.action;
    if (const ActionRow* const row = leaf.action(Model::kSample)) {
      ++sampled;
      earned += row->reward_sum > 0 ? 1 : 0;
    }
    for (int action = 0; action < Model::kActionCount; ++action) {
      if (depth == 3 || (depth == 0) != (action >= Model::kCheck)) continue;
      for (const ChildRow& group : leaf.groups(action)) {
        const ScenarioWalk::Seen seen = walk.seen(action, group.first);
        EXPECT_EQ(seen.is_terminal, group.terminal != 0);
        if (seen.is_terminal) continue;
        const Leaf below = expand(
            {1, leaf.handle, action, group.first, static_cast<std::uint32_t>(group.count), depth + 1, {}});
        walk.enter(action, group.first, group.count);
        self(self, below, group.count, depth + 1);
        walk.leave();
      }
    }
  };
  follow(follow, root, whole, 0);
  EXPECT_EQ(walk.members().size(), kScenarios);
  EXPECT_GT(sampled, 1);
  EXPECT_GT(earned, 0);
  EXPECT_LT(earned, sampled);
}

TEST_P(ScenarioWalkTest, TellsGroupsApartByWhatTheySee) {
  ModelWalk<Model> walk(*static_cast<const Model::Params*>(solver_.instance->params()), scenarios_,
                        setup_.key, setup_.weighted);
  const Leaf root = expand({0, kNoHandle, 0, 0, kScenarios * (setup_.weighted ? kScenarioMass : 1), 0, {}});
  const std::vector<ChildRow> groups = root.groups(Model::kCheck);
  ASSERT_EQ(groups.size(), 2U);
  EXPECT_NE(walk.seen(Model::kCheck, groups[0].first).key, walk.seen(Model::kCheck, groups[1].first).key);
}

INSTANTIATE_TEST_SUITE_P(Trees, ScenarioWalkTest, ::testing::Values(false, true),
                         [](const auto& info) { return info.param ? "Weighted" : "Exact"; });

}  // namespace
}  // namespace hypgen::testing
