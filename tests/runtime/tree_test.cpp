#include "hypgen/tree.hpp"

#include <gtest/gtest.h>

#include "hypgen/math.hpp"

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
  tree.backup(0);
  EXPECT_DOUBLE_EQ(tree.child(1).bounds.upper, 2.0);           // 8 * 0.5 / 2
  EXPECT_DOUBLE_EQ(tree.action(0).bounds.upper, 1 + 2 + 2.5);  // reward and children
  EXPECT_DOUBLE_EQ(tree.action(0).bounds.lower, 1 + 1 + 0.5);
  EXPECT_DOUBLE_EQ(tree.bounds(0).upper, 5.5);
  EXPECT_DOUBLE_EQ(tree.bounds(0).lower, 2.5);
  EXPECT_EQ(tree.action(tree.best_action(0)).action, 4);
}

TEST_F(TreeTest, ChoosesTheChildOfLargestExcess) {
  Tree tree(small_tree());
  tree.reset(root_);
  tree.expand(0, leaf());
  tree.backup(0);
  EXPECT_EQ(tree.best_child(0, 0.95), 2U);  // gap 2 against 1
  EXPECT_DOUBLE_EQ(tree.excess_uncertainty(2, 0.5), 2.0 - 0.5 * 0.5 * 3.0);
}

TEST_F(TreeTest, RaisesCrossedUpperBounds) {
  children_[0].upper_sum = fixed(1);
  Tree tree(small_tree());
  tree.reset(root_);
  tree.expand(0, leaf());
  EXPECT_EQ(tree.crossed(), 1U);
  EXPECT_DOUBLE_EQ(tree.child(1).bounds.upper, tree.child(1).bounds.lower);
}

TEST_F(TreeTest, PenalisesEachAction) {
  Tree tree(small_tree(0.25));
  tree.reset(root_);
  tree.expand(0, leaf());
  tree.backup(0);
  EXPECT_DOUBLE_EQ(tree.action(0).bounds.lower, 2.5 - 0.25);
  EXPECT_DOUBLE_EQ(tree.action(0).bounds.upper, 5.5 - 3 * 0.25);  // its own and two subtrees'
  EXPECT_DOUBLE_EQ(tree.action(0).bounds.plain_upper, 5.5);
}

TEST_F(TreeTest, DefaultPolicyReplacesABlockedNode) {
  Tree tree(small_tree(6.0));
  tree.reset(root_);
  tree.expand(0, leaf());
  tree.backup(0);
  const std::uint32_t node = tree.visit(0, 0, 1);
  EXPECT_EQ(tree.visit(0, 0, 1), node);
  EXPECT_TRUE(tree.is_blocked(node));  // 5.5 - 0 <= 6
  tree.make_default(node);
  EXPECT_DOUBLE_EQ(tree.bounds(node).plain_upper, tree.default_value(node));
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
  tree.backup(0);
  EXPECT_NE(tree.signature(0), before);
}

}  // namespace
}  // namespace hypgen
