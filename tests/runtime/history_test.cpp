// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "hypgen/solver/model_instance.hpp"
#include "test_solvers.hpp"

namespace hypgen::testing {
namespace {

// Tiger whose default policy opens a door at two growls more on the other side.
struct RememberingTiger : Tiger {
  static constexpr bool kHasHistory = true;
  struct History {
    std::uint32_t words[1];  // growls on the left minus growls on the right, plus 2
  };

  static void init_history(const Params&, const Fixed&, const State&, History& history) {
    history.words[0] = 2;
  }
  static void advance_history(const Params&, const Fixed&, const State&, int action, const Key& key,
                              const State&, const History& history, History& after) {
    after.words[0] = action != 0 ? 2 : key == 0 ? history.words[0] + 1 : history.words[0] - 1;
  }
  template <class D>
  static void roll_history(const Params& params, const Fixed& fixed, const State& state, int action, D& draws,
                           const State& next, const History& history, History& after) {
    const Key key = observe(params, fixed, state, action, draws, next);
    advance_history(params, fixed, state, action, key, next, history, after);
  }
  template <class D>
  static int default_policy(const Params&, const Fixed&, const State&, const History& history, D&) {
    return history.words[0] >= 4 ? 2 : history.words[0] == 0 ? 1 : 0;
  }
  static float lower(const Params&, const Fixed&, const State&, const History&) { return 0.0F; }
};

class HistoryTest : public ::testing::Test {
 protected:
  static constexpr std::uint32_t kScenarios = 60;
  static constexpr double kDiscount = 0.5;
  static constexpr int kDepth = 12;

  HistoryTest() : solver_(descriptor(), trials(1)) {
    solver_.belief->reserve(scenarios_, kScenarios);
    evaluator_ = solver_.instance->make_evaluator({kScenarios, std::size_t{1} << 20, kDiscount, kDepth});
  }

  static ModelDescriptor descriptor() {
    ModelDescriptor model = tiger_descriptor();
    model.create = make_descriptor<RememberingTiger>().create;
    return model;
  }

  RootResult begin() {
    solver_.belief->sample(setup_.key, 0, kScenarios, scenarios_);
    return evaluator_->begin_search(scenarios_, setup_);
  }

  LeafResult expand(const LeafRequest& request) {
    LeafResult result{};
    evaluator_->submit(0, {&request, 1});
    EXPECT_TRUE(evaluator_->poll(0, result));
    EXPECT_EQ(result.status, Status::kOk);
    return result;
  }

  // What following the policy's `action` at the leaf is worth, from its children.
  static double value_of(const LeafResult& leaf, int action) {
    const ActionRow& row = leaf.actions[static_cast<std::size_t>(action)];
    double sum = from_fixed_sum(row.reward_sum);
    for (std::uint32_t i = 0; i < row.child_count; ++i) {
      sum += kDiscount * from_fixed_sum(leaf.children[row.first_child + i].lower_sum);
    }
    return sum;
  }

  Solver solver_;
  ScenarioBuffer scenarios_;
  SearchSetup setup_{derive(0, StreamKind::kPlan, 0), kDepth, false, Clock::time_point::max()};
  std::unique_ptr<LeafEvaluator> evaluator_;
};

TEST_F(HistoryTest, TheBeliefKeepsTheAgentsHistory) {
  EXPECT_EQ(solver_.belief->default_action(setup_.key), 0);
  EXPECT_EQ(solver_.see(0, 0), Status::kOk);
  EXPECT_EQ(begin().default_action, 0);
  EXPECT_EQ(solver_.see(0, 0), Status::kOk);
  EXPECT_EQ(solver_.belief->default_action(setup_.key), 2);
  EXPECT_EQ(begin().default_action, 2);
  EXPECT_EQ(solver_.see(2, 0), Status::kOk);
  EXPECT_EQ(begin().default_action, 0);
}

// A rollout from a node is its policy's action, then the rollouts from the children: so each level's lower
// bounds follow from the next only if all of them have the right histories.
TEST_F(HistoryTest, ANodesHistoryIsWhatLeadsToIt) {
  constexpr double kRounding = 1e-3;
  const RootResult root = begin();
  const LeafResult first = expand({0, kNoHandle, 0, 0, kScenarios, 0, {}});
  EXPECT_NEAR(value_of(first, root.default_action), from_fixed_sum(root.row.lower_sum), kRounding);

  const ActionRow listen = first.actions[0];
  ASSERT_EQ(listen.child_count, 2U);
  const Span<const ChildRow> heard(&first.children[listen.first_child], 2);
  const std::uint64_t handle = first.handle;
  for (std::uint32_t side = 0; side < 2; ++side) {
    const LeafResult second = expand({0, handle, 0, heard[side].first, heard[side].count, 1, {}});
    EXPECT_NEAR(value_of(second, 0), from_fixed_sum(heard[side].lower_sum), kRounding);
    const std::uint64_t parent = second.handle;
    const ActionRow again = second.actions[0];
    const Span<const ChildRow> twice(&second.children[again.first_child], again.child_count);
    int opened = 0;
    for (const ChildRow& group : twice) {
      const LeafResult third = expand({0, parent, 0, group.first, group.count, 2, {}});
      const double lower = from_fixed_sum(group.lower_sum);
      const bool listens = std::abs(value_of(third, 0) - lower) < kRounding;
      const bool opens_left = std::abs(value_of(third, 1) - lower) < kRounding;
      const bool opens_right = std::abs(value_of(third, 2) - lower) < kRounding;
      EXPECT_TRUE(listens || opens_left || opens_right);
      opened += opens_left || opens_right ? 1 : 0;
    }
    EXPECT_EQ(opened, 1);  // after the same growl twice
  }
}

}  // namespace
}  // namespace hypgen::testing
