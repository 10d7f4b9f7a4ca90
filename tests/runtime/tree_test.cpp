// SPDX-License-Identifier: Apache-2.0
#include "hypgen/search/tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/search/atomic_maximum.hpp"
#include "hypgen/search/tree_check.hpp"

namespace hypgen {
namespace {

std::int64_t fixed(int value) { return math::to_fixed(value); }

TreeOptions small_tree(double pruning = 0.0) { return {std::size_t{1} << 16, 10, 0.5, pruning}; }

// Two scenarios; action 4 earns 1 in each and splits them, action 6 ends both.
class TreeTest : public ::testing::Test {
 protected:
  bool expand(Tree& tree, Node& node) const {
    return tree.expand(0, node, {0, Status::kOk, 9, 2, rows_, children_, {}});
  }

  std::vector<ActionRow> rows_ = {{fixed(2), fixed(18), fixed(6), 4, 0, 2, 0}, {fixed(3), 0, 0, 6, 2, 1, 0}};
  std::vector<ChildRow> children_ = {
      {fixed(8), fixed(4), 0, 1, 0}, {fixed(10), fixed(2), 1, 1, 0}, {0, 0, 0, 2, 1}};
  ChildRow root_ = {fixed(40), fixed(0), 0, 2, 0};
};

TEST_F(TreeTest, WeighsAndDiscountsBounds) {
  Tree tree(small_tree());
  ASSERT_TRUE(tree.reset(root_));
  Node& root = tree.root();
  EXPECT_DOUBLE_EQ(root.child->upper, 20.0);
  ASSERT_TRUE(expand(tree, root));
  EXPECT_DOUBLE_EQ(root.expanded()->uppers()[0], 1 + 2 + 2.5);  // reward and children
  EXPECT_DOUBLE_EQ(tree.action_lower(root, 0), 1 + 1 + 0.5);
  EXPECT_DOUBLE_EQ(root.child->upper, 5.5);
  EXPECT_DOUBLE_EQ(root.child->lower, 2.5);
  const ActionRule rule = tree.action_rule(root, tree.branch_rule({0.5, 1.0, 0.0}));
  const ActionChoice best = tree.best_action(root, rule);
  EXPECT_EQ(best.place, 0U);
  EXPECT_EQ(tree.next_action(root, rule, best).place, kNoIndex);  // 1.5 is below the lower bound
  const ActionTable* const table = tree.open_action(0, root, 0);
  ASSERT_NE(table, nullptr);
  EXPECT_EQ(tree.open_action(0, root, 0), table);
  EXPECT_DOUBLE_EQ(table->lower, 2.5);
  EXPECT_DOUBLE_EQ(table->children()[0].upper, 2.0);  // 8 * 0.5 / 2
  EXPECT_EQ(tree_fault(tree, false), "");
}

TEST_F(TreeTest, ChoosesTheChildOfLargestExcess) {
  Tree tree(small_tree());
  tree.reset(root_);
  Node& root = tree.root();
  expand(tree, root);
  ActionTable& table = *tree.open_action(0, root, 0);
  Child *const first = table.children(), *const second = first + 1;
  const BranchRule rule = tree.branch_rule({0.5, 1.0, 0.0});
  EXPECT_DOUBLE_EQ(rule.target, 0.5 * 0.5 * 3.0);
  EXPECT_DOUBLE_EQ(rule.loss, 3.0);
  EXPECT_EQ(tree.best_child(table, rule).child, second);  // gap 2 against 1
  Node& node = *tree.visit(0, root, 0, table, *second);
  tree.enter(node);
  EXPECT_EQ(tree.best_child(table, rule).child, first);  // a trial is below the other
  EXPECT_TRUE(tree.close(*tree.visit(0, root, 0, table, *first)));
  EXPECT_EQ(tree.best_child(table, rule).child, second);
  EXPECT_TRUE(tree.close(node));
  EXPECT_FALSE(tree.close(node));
  EXPECT_EQ(tree.best_child(table, rule).child, nullptr);
  EXPECT_TRUE(tree.best_child(table, rule).met_closed);
  EXPECT_FALSE(
      tree.best_child(table, tree.branch_rule({2.0, 1.0, 0.0})).met_closed);  // nothing is worth a trial
}

TEST_F(TreeTest, ExploresActionsThatFewTrialsTook) {
  rows_[1] = {0, fixed(16), fixed(8), 6, 2, 2, 0};
  children_ = {{fixed(8), fixed(4), 0, 1, 0},
               {fixed(10), fixed(2), 1, 1, 0},
               {fixed(8), fixed(4), 0, 1, 0},
               {fixed(8), fixed(4), 1, 1, 0}};
  Tree tree({std::size_t{1} << 16, 10, 0.5, 0.0, 1, true});
  tree.reset(root_);
  Node& root = tree.root();
  expand(tree, root);
  tree.enter(root);
  ActionRule rule = tree.action_rule(root, tree.branch_rule({0.5, 0.0, 0.5}));
  EXPECT_NEAR(rule.bonus, 0.5 * 3.0 * std::sqrt(std::log(2.0) / 2), 1e-6);
  EXPECT_EQ(tree.best_action(root, rule).place, 0U);  // 5.5 against 4, and neither taken
  ActionTable& table = *tree.open_action(0, root, 0);
  Node& node = *tree.visit(0, root, 0, table, table.children()[1]);
  for (int i = 0; i < 3; ++i) {
    tree.enter(root);
    tree.enter(node);
  }
  rule = tree.action_rule(root, tree.branch_rule({0.5, 0.0, 1.0}));
  const double bonus = 3.0 * std::sqrt(std::log(8.0) / 2);
  const ActionChoice best = tree.best_action(root, rule);
  EXPECT_EQ(best.place, 1U);
  EXPECT_NEAR(best.score, 4.0 + bonus, 1e-6);
  const ActionChoice next = tree.next_action(root, rule, best);
  EXPECT_EQ(next.place, 0U);
  EXPECT_NEAR(next.score, 5.5 + bonus / 2, 1e-6);
  EXPECT_EQ(tree.next_action(root, rule, next).place, kNoIndex);
  // A trial aims at 0.9 of the root's gap of 3, and below the second action there is one of 2.
  rule = tree.action_rule(root, tree.branch_rule({0.9, 0.0, 1.0}));
  EXPECT_EQ(tree.best_action(root, rule).place, 0U);
  for (int i = 0; i < 3; ++i) tree.leave(node);
  EXPECT_EQ(table.visits.load(), 0U);
}

TEST_F(TreeTest, ExpansionReopensWhatWasClosedForIt) {
  Tree tree(small_tree());
  tree.reset(root_);
  Node& root = tree.root();
  expand(tree, root);
  ActionTable& table = *tree.open_action(0, root, 0);
  Node& node = *tree.visit(0, root, 0, table, table.children()[1]);
  tree.enter(root);
  tree.enter(node);
  tree.close(node);
  tree.close(root);
  const std::vector<ChildRow> child_rows = {{fixed(9), fixed(3), 0, 1, 0}};
  const std::vector<ActionRow> rows = {{fixed(1), fixed(9), fixed(3), 4, 0, 1, 0}};
  ASSERT_TRUE(tree.expand(0, node, {0, Status::kOk, 9, 1, rows, child_rows, {}}));
  EXPECT_FALSE(tree.is_closed(node));
  EXPECT_FALSE(tree.is_closed(root));
  EXPECT_DOUBLE_EQ(node.child->lower, 0.25 + 0.375);
  EXPECT_DOUBLE_EQ(table.lower, 1 + 1 + 0.625);  // its action sees it, the root not yet
  EXPECT_DOUBLE_EQ(root.child->lower, 2.5);
  EXPECT_NE(tree_fault(tree, false), "");
  tree.backup(node);
  EXPECT_DOUBLE_EQ(root.child->lower, 2.625);
  EXPECT_DOUBLE_EQ(root.child->upper, 5.5 - 2.5 + 0.25 + 1.125);
  EXPECT_EQ(root.child->visits(), 1U);
  EXPECT_EQ(root.child->in_flight(), 0U);
  EXPECT_EQ(tree_fault(tree, false), "");
}

TEST_F(TreeTest, RaisesCrossedUpperBounds) {
  children_[0].upper_sum = fixed(1);
  rows_[0].upper_sum = fixed(14);
  Tree tree(small_tree());
  tree.reset(root_);
  expand(tree, tree.root());
  EXPECT_EQ(tree.crossed(0), 0U);
  const ActionTable& table = *tree.open_action(0, tree.root(), 0);
  EXPECT_EQ(tree.crossed(0), 1U);
  EXPECT_DOUBLE_EQ(table.children()[0].upper, table.children()[0].lower);
}

TEST_F(TreeTest, PenalisesEachAction) {
  Tree tree(small_tree(0.25));
  tree.reset(root_);
  expand(tree, tree.root());
  const Expansion& expansion = *tree.root().expanded();
  EXPECT_DOUBLE_EQ(tree.action_lower(tree.root(), 0), 2.5 - 0.25);
  EXPECT_DOUBLE_EQ(expansion.uppers()[0], 5.5 - 3 * 0.25);  // its own and two subtrees'
  EXPECT_DOUBLE_EQ(expansion.plain_uppers()[0], 5.5);
  EXPECT_EQ(tree_fault(tree, false), "");
}

TEST_F(TreeTest, DefaultPolicyReplacesABlockedNode) {
  Tree tree(small_tree(6.0));
  tree.reset(root_);
  Node& root = tree.root();
  expand(tree, root);
  ActionTable& table = *tree.open_action(0, root, 0);
  Node& node = *tree.visit(0, root, 0, table, table.children()[0]);
  EXPECT_EQ(tree.visit(0, root, 0, table, table.children()[0]), &node);
  EXPECT_EQ(tree.nodes(0), 2U);
  EXPECT_TRUE(tree.is_blocked(node));  // 5.5 - 0 <= 6
  tree.make_default(node);
  EXPECT_DOUBLE_EQ(node.child->plain_upper, node.child->default_value);
}

TEST(Scan, FindsTheFirstOfTheLargest) {
  std::vector<double> numbers;
  std::vector<std::atomic<double>> shared(70);
  for (int i = 0; i < 70; ++i) {
    numbers.push_back((i * 37) % 53);
    shared[numbers.size() - 1] = numbers.back();
    const auto wanted = std::max_element(numbers.begin(), numbers.end());
    const Largest found = largest(shared.data(), static_cast<std::uint32_t>(numbers.size()));
    EXPECT_EQ(found.value, *wanted);
    EXPECT_EQ(found.place, static_cast<std::uint32_t>(wanted - numbers.begin()));
  }
}

TEST_F(TreeTest, SaysWhenItIsFull) {
  Tree tree({192, 10, 0.5, 0.0});
  ASSERT_TRUE(tree.reset(root_));
  EXPECT_FALSE(expand(tree, tree.root()));
  EXPECT_EQ(tree.root().expanded(), nullptr);
  Tree none({0, 10, 0.5, 0.0});
  EXPECT_FALSE(none.reset(root_));
}

TEST_F(TreeTest, SignatureSeesBounds) {
  Tree tree(small_tree());
  tree.reset(root_);
  const std::uint64_t before = tree.signature(0);
  expand(tree, tree.root());
  EXPECT_NE(tree.signature(0), before);
}

}  // namespace
}  // namespace hypgen
