// SPDX-License-Identifier: Apache-2.0
// The tree's protocols one by one, by threads that begin at the same moment, over and over from the same
// start.
//
// tests/unit/test_tree_protocols.py walks through all orders of a model of them.
#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>
#include <functional>
#include <thread>
#include <vector>

#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/search/monotone.hpp"
#include "hypgen/search/tree_check.hpp"

namespace hypgen {
namespace {

constexpr int kRounds = 3000;

// Runs `work(thread)` by all threads at once, `rounds` times, with `before` and `after` in between.
void race(std::size_t threads, const std::function<void()>& before,
          const std::function<void(std::size_t)>& work, const std::function<void()>& after) {
  std::atomic<int> round{0};
  std::atomic<std::size_t> ended{0};
  const auto take_part = [&](std::size_t thread) {
    for (int wanted = 1; wanted <= kRounds; ++wanted) {
      while (round.load() < wanted) sched_yield();
      work(thread);
      ended.fetch_add(1);
    }
  };
  std::vector<std::thread> others;
  for (std::size_t i = 1; i < threads; ++i) others.emplace_back(take_part, i);
  for (int i = 1; i <= kRounds; ++i) {
    before();
    ended = 0;
    round = i;
    work(0);
    ended.fetch_add(1);
    while (ended.load() < threads) sched_yield();
    after();
  }
  for (std::thread& thread : others) thread.join();
}

std::int64_t fixed(double value) { return math::to_fixed(static_cast<float>(value)); }

// A root of two scenarios and three actions, each with one child of both; the first action's is the best by
// far.
class ProtocolTest : public ::testing::Test {
 protected:
  ProtocolTest() : tree_({std::size_t{1} << 20, 10, 1.0, 0.0, 3}) {
    for (int a = 0; a < 3; ++a) {
      const double upper = 20.0 - 2 * a;
      groups_.push_back({fixed(upper), fixed(1), 0, 2, 0});
      rows_.push_back({0, fixed(upper), fixed(1), a, static_cast<std::uint32_t>(a), 1, 0});
    }
  }

  void reset() {
    ASSERT_TRUE(tree_.reset({fixed(40), 0, 0, 2, 0}));
    tree_.enter(tree_.root());
    ASSERT_TRUE(tree_.expand(0, tree_.root(), {0, Status::kOk, 0, 2, rows_, groups_, {}}));
    tree_.backup(tree_.root());
  }

  Node& visit(std::size_t thread, std::uint32_t action) {
    ActionTable& table = *tree_.open_action(thread, tree_.root(), action);
    return *tree_.visit(thread, tree_.root(), action, table, table.children()[0]);
  }

  // A trial to the child of an action whose expansion has these bounds.
  void expand(std::size_t thread, std::uint32_t action, double lower, double upper) {
    ChildRow& group = found_groups_[thread];
    ActionRow& row = found_rows_[thread];
    group = {fixed(upper), fixed(lower), 0, 2, 0};
    row = {0, fixed(upper), fixed(lower), 0, 0, 1, 0};
    Node& node = visit(thread, action);
    tree_.enter(tree_.root());
    tree_.enter(node);
    ASSERT_TRUE(tree_.close(node));
    ASSERT_TRUE(tree_.expand(thread, node, {0, Status::kOk, 0, 2, {&row, 1}, {&group, 1}, {}}));
    tree_.backup(node);
  }

  Tree tree_;
  std::vector<ChildRow> groups_;
  std::vector<ActionRow> rows_;
  ChildRow found_groups_[3];
  ActionRow found_rows_[3];
};

TEST_F(ProtocolTest, TheLargestOfLoweredBoundsIsFound) {
  race(
      3, [&] { reset(); },
      [&](std::size_t thread) {
        expand(thread, static_cast<std::uint32_t>(thread), 2, 3 + static_cast<double>(thread));
      },
      [&] {
        EXPECT_EQ(tree_fault(tree_, false), "");
        EXPECT_DOUBLE_EQ(tree_.root().child->upper, 2.5);
        EXPECT_DOUBLE_EQ(tree_.root().child->lower, 1.0);
        EXPECT_EQ(tree_.root().child->visits(), 4U);
      });
}

TEST_F(ProtocolTest, BoundsThatRiseAreSeen) {
  // The best action's child crosses: its lower bound passes the upper one while others fall below that.
  race(
      3, [&] { reset(); },
      [&](std::size_t thread) {
        thread == 0 ? expand(0, 0, 24, 24) : expand(thread, static_cast<std::uint32_t>(thread), 2, 3);
      },
      [&] {
        EXPECT_EQ(tree_fault(tree_, false), "");
        EXPECT_DOUBLE_EQ(tree_.root().child->lower, 12.0);
        EXPECT_DOUBLE_EQ(tree_.root().child->upper, 12.0);
      });
}

TEST_F(ProtocolTest, ALeafIsClaimedOnceAndTablesAndNodesAreMadeOnce) {
  std::atomic<int> claims{0};
  Node* seen[3];
  race(
      3,
      [&] {
        reset();
        claims = 0;
      },
      [&](std::size_t thread) {
        seen[thread] = &visit(thread, 1);
        if (tree_.close(*seen[thread])) ++claims;
      },
      [&] {
        EXPECT_EQ(claims, 1);
        EXPECT_EQ(seen[0], seen[1]);
        EXPECT_EQ(seen[0], seen[2]);
        EXPECT_EQ(tree_.nodes(0) + tree_.nodes(1) + tree_.nodes(2), 2U);
      });
}

TEST(Monotone, BoundsThatCrossMeetAndEveryChangeIsOwned) {
  std::atomic<double> lower{0.0}, upper{0.0};
  double changes[3];
  race(
      3,
      [&] {
        lower = 0.0;
        upper = 9.0;
      },
      [&](std::size_t thread) {
        constexpr double kNoLimit = 1e9;
        double& change = changes[thread] = 0.0;
        if (thread == 0) {
          change = lower_to(upper, lower, 2.0);
        } else {
          raise_to(lower, 2.0 + static_cast<double>(thread));
          change = lower_to(upper, lower, kNoLimit);
        }
      },
      [&] {
        EXPECT_EQ(lower, 4.0);
        EXPECT_EQ(upper, 4.0);
        EXPECT_EQ(9.0 + changes[0] + changes[1] + changes[2], 4.0);
      });
}

TEST(Monotone, NoAdditionIsLost) {
  std::atomic<double> sum{0.0};
  race(3, [] {}, [&](std::size_t thread) { add(sum, static_cast<double>(thread)); }, [] {});
  EXPECT_EQ(sum, 3.0 * kRounds);
}

}  // namespace
}  // namespace hypgen
