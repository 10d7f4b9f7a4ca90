#include "hypgen/tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "hypgen/math.hpp"
#include "hypgen/scan.hpp"

namespace hypgen {
namespace {

std::int64_t fixed(int value) { return math::to_fixed(value); }

TreeOptions small_tree(double pruning = 0.0) { return {std::size_t{1} << 16, 10, 0.5, pruning}; }

// Two scenarios; action 4 earns 1 in each and splits them, action 6 ends both.
class TreeTest : public ::testing::Test {
 protected:
  LeafResult leaf() const { return {0, Status::kOk, 9, 2, rows_, children_, {}}; }

  std::vector<ActionRow> rows_ = {{fixed(2), fixed(18), fixed(6), 4, 0, 2, 0}, {fixed(3), 0, 0, 6, 2, 1, 0}};
  std::vector<ChildRow> children_ = {
      {fixed(8), fixed(4), 0, 1, 0}, {fixed(10), fixed(2), 1, 1, 0}, {0, 0, 0, 2, 1}};
  ChildRow root_ = {fixed(40), fixed(0), 0, 2, 0};
};

TEST_F(TreeTest, WeighsAndDiscountsBounds) {
  Tree tree(small_tree());
  ASSERT_TRUE(tree.reset(root_));
  EXPECT_DOUBLE_EQ(tree.bounds(0).upper, 20.0);
  ASSERT_TRUE(tree.expand(0, leaf()));
  EXPECT_DOUBLE_EQ(tree.action_bounds(0).upper, 1 + 2 + 2.5);  // reward and children
  EXPECT_DOUBLE_EQ(tree.action_bounds(0).lower, 1 + 1 + 0.5);
  EXPECT_DOUBLE_EQ(tree.bounds(0).upper, 5.5);
  EXPECT_DOUBLE_EQ(tree.bounds(0).lower, 2.5);
  EXPECT_EQ(tree.action(tree.node(0).best).action, 4);
  EXPECT_EQ(tree.next_action(0, 0), kNoIndex);  // 1.5 is below the lower bound
  ASSERT_TRUE(tree.open(0, 0));
  EXPECT_DOUBLE_EQ(tree.child(1).bounds.upper, 2.0);  // 8 * 0.5 / 2
}

TEST_F(TreeTest, ChoosesTheChildOfLargestExcess) {
  Tree tree(small_tree());
  tree.reset(root_);
  tree.expand(0, leaf());
  tree.open(0, 0);
  EXPECT_EQ(tree.best_child(0, {0.5, 1.0}).child, 2U);  // gap 2 against 1
  EXPECT_DOUBLE_EQ(tree.excess_uncertainty(2, 0.5), 2.0 - 0.5 * 0.5 * 3.0);
  const std::uint32_t node = tree.visit(0, 0, 2);
  tree.enter(node);
  EXPECT_EQ(tree.best_child(0, {0.5, 1.0}).child, 1U);  // a trial is below the other
  tree.close(tree.visit(0, 0, 1));
  EXPECT_EQ(tree.best_child(0, {0.5, 1.0}).child, 2U);
  tree.close(node);
  EXPECT_EQ(tree.best_child(0, {0.5, 1.0}).child, kNoIndex);
  EXPECT_TRUE(tree.best_child(0, {0.5, 1.0}).met_closed);
  EXPECT_FALSE(tree.best_child(0, {2.0, 1.0}).met_closed);  // nothing is worth a trial
}

TEST_F(TreeTest, ExpansionReopensWhatWasClosedForIt) {
  Tree tree(small_tree());
  tree.reset(root_);
  tree.expand(0, leaf());
  tree.open(0, 0);
  const std::uint32_t node = tree.visit(0, 0, 2);
  tree.enter(0);
  tree.enter(node);
  tree.close(node);
  tree.close(0);
  children_ = {{fixed(9), fixed(3), 0, 1, 0}};
  rows_ = {{fixed(1), fixed(9), fixed(3), 4, 0, 1, 0}};
  ASSERT_TRUE(tree.expand(node, leaf()));
  EXPECT_FALSE(tree.is_closed(node));
  EXPECT_FALSE(tree.is_closed(0));
  EXPECT_DOUBLE_EQ(tree.bounds(node).lower, 0.25 + 0.375);
  EXPECT_DOUBLE_EQ(tree.action_bounds(0).lower, 1 + 1 + 0.625);  // its action sees it, the root not yet
  EXPECT_DOUBLE_EQ(tree.bounds(0).lower, 2.5);
  tree.backup(node);
  EXPECT_DOUBLE_EQ(tree.bounds(0).lower, 2.625);
  EXPECT_DOUBLE_EQ(tree.bounds(0).upper, 5.5 - 2.5 + 0.25 + 1.125);
  EXPECT_EQ(tree.node(0).visits, 1U);
  EXPECT_EQ(tree.child(0).in_flight, 0U);
}

TEST_F(TreeTest, RaisesCrossedUpperBounds) {
  children_[0].upper_sum = fixed(1);
  rows_[0].upper_sum = fixed(14);
  Tree tree(small_tree());
  tree.reset(root_);
  tree.expand(0, leaf());
  EXPECT_EQ(tree.crossed(), 0U);
  tree.open(0, 0);
  EXPECT_EQ(tree.crossed(), 1U);
  EXPECT_DOUBLE_EQ(tree.child(1).bounds.upper, tree.child(1).bounds.lower);
}

TEST_F(TreeTest, PenalisesEachAction) {
  Tree tree(small_tree(0.25));
  tree.reset(root_);
  tree.expand(0, leaf());
  EXPECT_DOUBLE_EQ(tree.action_bounds(0).lower, 2.5 - 0.25);
  EXPECT_DOUBLE_EQ(tree.action_bounds(0).upper, 5.5 - 3 * 0.25);  // its own and two subtrees'
  EXPECT_DOUBLE_EQ(tree.action_bounds(0).plain_upper, 5.5);
}

TEST_F(TreeTest, DefaultPolicyReplacesABlockedNode) {
  Tree tree(small_tree(6.0));
  tree.reset(root_);
  tree.expand(0, leaf());
  const std::uint32_t node = tree.visit(0, 0, 1);
  EXPECT_EQ(tree.visit(0, 0, 1), node);
  EXPECT_TRUE(tree.is_blocked(node));  // 5.5 - 0 <= 6
  tree.make_default(node);
  EXPECT_DOUBLE_EQ(tree.bounds(node).plain_upper, tree.default_value(node));
}

TEST(Scan, FindsTheFirstOfTheLargest) {
  std::vector<double> numbers;
  for (int i = 0; i < 70; ++i) {
    numbers.push_back((i * 37) % 53);
    const auto wanted = std::max_element(numbers.begin(), numbers.end());
    EXPECT_EQ(largest(numbers.data(), numbers.size()), *wanted);
    EXPECT_EQ(first_largest(numbers.data(), numbers.size()),
              static_cast<std::size_t>(wanted - numbers.begin()));
  }
}

TEST_F(TreeTest, SaysWhenItIsFull) {
  Tree tree({1, 10, 0.5, 0.0});
  ASSERT_TRUE(tree.reset(root_));
  EXPECT_FALSE(tree.expand(0, leaf()));
  EXPECT_FALSE(tree.node(0).expanded());
}

TEST_F(TreeTest, SignatureSeesBounds) {
  Tree tree(small_tree());
  tree.reset(root_);
  const std::uint64_t before = tree.signature(0);
  tree.expand(0, leaf());
  EXPECT_NE(tree.signature(0), before);
}

}  // namespace
}  // namespace hypgen
