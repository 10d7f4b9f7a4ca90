#include <gtest/gtest.h>

#include "hypgen/cpu_evaluator.hpp"
#include "test_solvers.hpp"

namespace hypgen::testing {
namespace {

class EvaluatorTest : public ::testing::Test {
 protected:
  EvaluatorTest() : solver_(rock_sample_descriptor<4, 3>(), trials(1)) {
    solver_.belief->reserve(scenarios_, kScenarios);
    solver_.belief->sample(setup_.key, 0, kScenarios, scenarios_);
    evaluator_ = solver_.instance->make_evaluator({kScenarios, std::size_t{1} << 20, 0.95, 20});
  }

  LeafResult expand(const LeafRequest& request) {
    LeafResult result{};
    EXPECT_EQ(evaluator_->submit({&request, 1}), 1U);
    EXPECT_TRUE(evaluator_->poll(result));
    EXPECT_FALSE(evaluator_->poll(result));
    return result;
  }

  static constexpr std::size_t kScenarios = 40;
  Solver solver_;
  ScenarioBuffer scenarios_;
  SearchSetup setup_{derive(0, StreamKind::kPlan, 0), 20, false, Clock::time_point::max()};
  std::unique_ptr<LeafEvaluator> evaluator_;
};

TEST_F(EvaluatorTest, EveryScenarioIsInOneGroupOfEachAction) {
  const RootResult root = evaluator_->begin_search(scenarios_, setup_);
  EXPECT_EQ(root.row.count, kScenarios);
  EXPECT_EQ(root.default_action, SmallRockSample::kEast);
  EXPECT_LE(root.row.lower_sum, root.row.upper_sum);
  const LeafResult leaf = expand({0, kNoHandle, 0, 0, 0, {}});
  ASSERT_EQ(leaf.status, Status::kOk);
  std::size_t next_child = 0;
  for (const ActionRow& row : leaf.actions) {
    EXPECT_NE(row.action, SmallRockSample::kSample);  // no rock at the start
    EXPECT_EQ(row.first_child, next_child);
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < row.child_count; ++i) count += leaf.children[next_child++].count;
    EXPECT_EQ(count, kScenarios);
    EXPECT_EQ(row.child_count, row.action >= SmallRockSample::kCheck ? 2U : 1U);
  }
  EXPECT_EQ(next_child, leaf.children.size());
}

TEST_F(EvaluatorTest, MembersOfAGroupAreFoundAgain) {
  evaluator_->begin_search(scenarios_, setup_);
  const LeafResult root = expand({0, kNoHandle, 0, 0, 0, {}});
  const ActionRow check = root.actions[root.actions.size() - 1];
  const std::vector<ChildRow> groups(&root.children[check.first_child],
                                     &root.children[check.first_child] + check.child_count);
  const std::uint64_t handle = root.handle;
  for (std::uint32_t group = 0; group < groups.size(); ++group) {
    const LeafResult child = expand({group, handle, check.action, group, 1, {}});
    EXPECT_EQ(child.ticket, group);
    EXPECT_EQ(child.actions[0].count, groups[group].count);
  }
}

TEST_F(EvaluatorTest, GainsAreRelativeToTheDefaultAction) {
  evaluator_->begin_search(scenarios_, setup_);
  const LeafResult leaf = expand({0, kNoHandle, 0, 0, 0, {}});
  for (const ActionRow& row : leaf.actions) {
    if (row.action == SmallRockSample::kEast) {
      EXPECT_EQ(row.gain_sum, 0);
      EXPECT_EQ(row.gain_square_sum, 0.0);
    } else {
      EXPECT_LT(row.gain_sum, 0);  // a step later at the exit
      EXPECT_GT(row.gain_square_sum, 0.0);
    }
  }
}

TEST_F(EvaluatorTest, TriesTheActionsAskedFor) {
  evaluator_->begin_search(scenarios_, setup_);
  const std::vector<int> wanted = {SmallRockSample::kSouth, SmallRockSample::kSample,
                                   SmallRockSample::kCheck};
  const LeafResult leaf = expand({0, kNoHandle, 0, 0, 0, wanted});
  ASSERT_EQ(leaf.actions.size(), 2U);
  EXPECT_EQ(leaf.actions[0].action, SmallRockSample::kSouth);
  EXPECT_EQ(leaf.actions[1].action, SmallRockSample::kCheck);
}

TEST_F(EvaluatorTest, StopsAtTheDeadline) {
  setup_.deadline = Clock::now();
  EXPECT_EQ(evaluator_->begin_search(scenarios_, setup_).status, Status::kDeadline);
}

TEST_F(EvaluatorTest, RefusesScenariosOfAnotherModel) {
  ScenarioBuffer wrong;
  wrong.reserve(4, 4, 1, 1);
  wrong.clear(0);
  wrong.push(std::uint32_t{0}, std::uint32_t{0});
  EXPECT_EQ(evaluator_->begin_search(wrong, setup_).status, Status::kEvaluatorFailed);
}

TEST_F(EvaluatorTest, SaysWhenItsMemoryIsFull) {
  evaluator_ = solver_.instance->make_evaluator({kScenarios, 1, 0.95, 20});
  evaluator_->begin_search(scenarios_, setup_);
  const LeafResult root = expand({0, kNoHandle, 0, 0, 0, {}});
  ASSERT_EQ(root.status, Status::kOk);
  EXPECT_EQ(expand({0, root.handle, SmallRockSample::kEast, 0, 1, {}}).status, Status::kMemoryFull);
}

// What the memo must not change: the same bounds as when every state is rolled out.
TEST_F(EvaluatorTest, MemoGivesWhatWasComputed) {
  BoundsMemo<SmallRockSample> memo;
  memo.clear();
  SmallRockSample::State a{{1, 2}}, b{{1, 3}};
  int computed = 0;
  const auto compute = [&] { return ScenarioBounds{++computed, 0}; };
  EXPECT_EQ(memo.find_or(a, {}, compute).upper, 1);
  EXPECT_EQ(memo.find_or(b, {}, compute).upper, 2);
  EXPECT_EQ(memo.find_or(b, {}, compute).upper, 2);
  memo.clear();
  EXPECT_EQ(memo.find_or(b, {}, compute).upper, 3);
}

}  // namespace
}  // namespace hypgen::testing
