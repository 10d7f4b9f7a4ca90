// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cfenv>
#include <cstring>
#include <thread>
#include <vector>

#include "hypgen/leaves/cpu_evaluator.hpp"
#include "hypgen/verify/leaf_check.hpp"
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
    EXPECT_EQ(evaluator_->submit(0, {&request, 1}), 1U);
    EXPECT_TRUE(evaluator_->poll(0, result));
    EXPECT_FALSE(evaluator_->poll(0, result));
    return result;
  }

  static LeafRequest root_request(Span<const int> actions = {}) {
    return {0, kNoHandle, 0, 0, kScenarios, 0, actions};
  }

  static constexpr std::uint32_t kScenarios = 40;
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
  const LeafResult leaf = expand(root_request());
  ASSERT_EQ(leaf.status, Status::kOk);
  std::size_t next_child = 0;
  for (const ActionRow& row : leaf.actions) {
    EXPECT_NE(row.action, SmallRockSample::kSample);  // no rock at the start
    EXPECT_EQ(row.first_child, next_child);
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < row.child_count; ++i) count += leaf.children[next_child++].count;
    EXPECT_EQ(count, kScenarios);
    EXPECT_EQ(leaf.children[row.first_child].first, 0U);
    EXPECT_EQ(row.child_count, row.action >= SmallRockSample::kCheck ? 2U : 1U);
  }
  EXPECT_EQ(next_child, leaf.children.size());
}

TEST_F(EvaluatorTest, MembersOfAGroupAreFoundAgain) {
  evaluator_->begin_search(scenarios_, setup_);
  const LeafResult root = expand(root_request());
  const ActionRow check = root.actions[root.actions.size() - 1];
  const Span<const ChildRow> groups(&root.children[check.first_child], check.child_count);
  const std::uint64_t handle = root.handle;
  for (std::uint32_t i = 0; i < groups.size(); ++i) {
    const LeafResult child = expand({i, handle, check.action, groups[i].first, groups[i].count, 1, {}});
    EXPECT_EQ(child.status, Status::kOk);
    EXPECT_EQ(child.ticket, i);
    EXPECT_EQ(child.count, groups[i].count);
    EXPECT_TRUE(child.gains.empty());
  }
  const LeafResult wrong = expand({0, handle, check.action, groups[0].first, groups[0].count + 1U, 1, {}});
  EXPECT_EQ(wrong.status, Status::kEvaluatorFailed);
}

TEST_F(EvaluatorTest, AnActionsBoundsAreTheSumsOfItsChildren) {
  evaluator_->begin_search(scenarios_, setup_);
  const LeafResult leaf = expand(root_request());
  for (const ActionRow& row : leaf.actions) {
    std::int64_t upper = 0, lower = 0;
    for (std::uint32_t i = 0; i < row.child_count; ++i) {
      const ChildRow& child = leaf.children[row.first_child + i];
      upper += std::max(child.upper_sum, child.lower_sum);
      lower += child.lower_sum;
    }
    EXPECT_EQ(row.upper_sum, upper);
    EXPECT_EQ(row.lower_sum, lower);
  }
}

TEST_F(EvaluatorTest, RowsStayUntilRelease) {
  evaluator_->begin_search(scenarios_, setup_);
  const LeafResult root = expand(root_request());
  const std::vector<ActionRow> actions(root.actions.begin(), root.actions.end());
  const std::vector<Gain> gains(root.gains.begin(), root.gains.end());
  for (int i = 0; i < 20; ++i) expand({0, root.handle, SmallRockSample::kEast, 0, kScenarios, 1, {}});
  expand(root_request());
  EXPECT_EQ(std::memcmp(actions.data(), root.actions.begin(), actions.size() * sizeof(ActionRow)), 0);
  EXPECT_EQ(std::memcmp(gains.data(), root.gains.begin(), gains.size() * sizeof(Gain)), 0);
}

// Each thread expands leaves below parents of all, and gives the rows that one thread gives.
TEST_F(EvaluatorTest, ThreadsGiveTheSameRows) {
  constexpr std::size_t kThreads = 4;
  EvaluatorOptions options;
  options.max_scenarios = kScenarios;
  options.memory_bytes = std::size_t{1} << 22;
  options.max_depth = 20;
  options.in_flight = options.threads = kThreads;
  evaluator_ = solver_.instance->make_evaluator(options);
  ASSERT_EQ(evaluator_->threads(), kThreads);
  evaluator_->begin_search(scenarios_, setup_);
  const LeafResult root = expand(root_request());
  const ActionRow check = root.actions[root.actions.size() - 1];
  const ChildRow group = root.children[check.first_child];
  LeafRequest request;
  request.parent = root.handle;
  request.action = check.action;
  request.first = group.first;
  request.count = group.count;
  request.depth = 1;
  std::vector<LeafResult> results(kThreads);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      evaluator_->attach(t);
      for (int i = 0; i < 20; ++i) {
        if (evaluator_->submit(t, {&request, 1}) == 1) evaluator_->poll(t, results[t]);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  const LeafResult expected = expand(request);
  for (const LeafResult& result : results) {
    ASSERT_EQ(result.status, Status::kOk);
    ASSERT_EQ(result.actions.size(), expected.actions.size());
    ASSERT_EQ(result.children.size(), expected.children.size());
    EXPECT_EQ(std::memcmp(result.actions.begin(), expected.actions.begin(),
                          expected.actions.size() * sizeof(ActionRow)),
              0);
    EXPECT_EQ(std::memcmp(result.children.begin(), expected.children.begin(),
                          expected.children.size() * sizeof(ChildRow)),
              0);
  }
  EXPECT_EQ(evaluator_->stats().leaves, 20U * kThreads + 2U);
}

TEST_F(EvaluatorTest, TreesWithLeavesOfSeveralThreadsAreTheSame) {
  EvaluatorOptions options;
  options.max_scenarios = kScenarios;
  options.memory_bytes = std::size_t{1} << 24;
  options.max_depth = 20;
  options.in_flight = kMostInFlight;
  const auto one = solver_.instance->make_evaluator(options);
  options.threads = 5;
  const auto five = solver_.instance->make_evaluator(options);
  const LeafComparison found = compare_leaves(*one, *five, scenarios_, setup_, 300, 1);
  EXPECT_EQ(found.difference, "");
  EXPECT_GE(found.leaves, 300U);
}

TEST_F(EvaluatorTest, ServesFewerThreadsWithLittleMemory) {
  EvaluatorOptions options;
  options.max_scenarios = kScenarios;
  options.memory_bytes = 1;
  options.max_depth = 20;
  options.threads = 16;
  EXPECT_EQ(solver_.instance->make_evaluator(options)->threads(), 1U);
}

// Fewer outcomes at once and fewer draws that are kept: the same rows.
TEST_F(EvaluatorTest, LittleScratchGivesTheSameRows) {
  evaluator_->begin_search(scenarios_, setup_);
  const LeafResult expected = expand(root_request());
  const auto small = solver_.instance->make_evaluator({kScenarios, 1, 0.95, 20});
  small->begin_search(scenarios_, setup_);
  const LeafRequest request = root_request();
  LeafResult result{};
  small->submit(0, {&request, 1});
  ASSERT_TRUE(small->poll(0, result));
  ASSERT_EQ(result.children.size(), expected.children.size());
  EXPECT_EQ(std::memcmp(result.children.begin(), expected.children.begin(),
                        expected.children.size() * sizeof(ChildRow)),
            0);
}

// A caller may have another floating-point mode.
TEST_F(EvaluatorTest, AttachSetsTheDefaultMode) {
  std::fesetround(FE_UPWARD);
  evaluator_->attach(0);
  EXPECT_EQ(std::fegetround(), FE_TONEAREST);
}

TEST_F(EvaluatorTest, CountsWhatItDid) {
  evaluator_->begin_search(scenarios_, setup_);
  const std::uint64_t bounding = evaluator_->stats().steps;
  const LeafResult leaf = expand(root_request());
  EXPECT_EQ(evaluator_->stats().leaves, 1U);
  EXPECT_GE(evaluator_->stats().steps, bounding + kScenarios * leaf.actions.size());
}

TEST_F(EvaluatorTest, GainsAreRelativeToTheDefaultAction) {
  evaluator_->begin_search(scenarios_, setup_);
  const LeafResult leaf = expand(root_request());
  ASSERT_EQ(leaf.gains.size(), leaf.actions.size());
  for (std::size_t i = 0; i < leaf.actions.size(); ++i) {
    if (leaf.actions[i].action == SmallRockSample::kEast) {
      EXPECT_EQ(leaf.gains[i].sum, 0);
      EXPECT_EQ(leaf.gains[i].square_sum, 0.0);
    } else {
      EXPECT_LT(leaf.gains[i].sum, 0);  // a step later at the exit
      EXPECT_GT(leaf.gains[i].square_sum, 0.0);
    }
  }
}

TEST_F(EvaluatorTest, TriesTheActionsAskedFor) {
  evaluator_->begin_search(scenarios_, setup_);
  const std::vector<int> wanted = {SmallRockSample::kSouth, SmallRockSample::kSample,
                                   SmallRockSample::kCheck};
  const LeafResult leaf = expand(root_request(wanted));
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
  const LeafResult root = expand(root_request());
  ASSERT_EQ(root.status, Status::kOk);
  LeafRequest child;
  child.parent = root.handle;
  child.action = SmallRockSample::kEast;
  child.count = kScenarios;
  child.depth = 1;
  Status status = Status::kOk;
  for (int i = 0; i < 50 && status == Status::kOk; ++i) status = expand(child).status;
  EXPECT_EQ(status, Status::kMemoryFull);
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
