// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "hypgen/leaves/grouping.hpp"
#include "hypgen/memory/arena.hpp"

namespace hypgen {
namespace {

TEST(Arena, HandsOutInOrderUntilFull) {
  Arena<int> arena(5);
  EXPECT_EQ(arena.allocate(3), 0U);
  EXPECT_EQ(arena.allocate(3), Arena<int>::kFull);
  EXPECT_EQ(arena.allocate(2), 3U);
  EXPECT_FALSE(arena.fits(1));
  EXPECT_EQ(arena.allocate(0), 5U);
  arena.reset();
  EXPECT_EQ(arena.allocate(5), 0U);
}

TEST(Grouping, NumbersByFirstAppearance) {
  ActionGrouping<std::uint64_t> grouping(4);
  grouping.clear();
  EXPECT_EQ(grouping.number(false, 77), 0U);
  EXPECT_EQ(grouping.number(true, 0), 1U);
  EXPECT_EQ(grouping.number(false, 0), 2U);
  EXPECT_EQ(grouping.number(false, 77), 0U);
  EXPECT_EQ(grouping.number(true, 0), 1U);
  EXPECT_EQ(grouping.count(), 3U);
  grouping.clear();
  EXPECT_EQ(grouping.number(false, 0), 0U);
}

TEST(Grouping, HoldsAsManyKeysAsPromised) {
  Grouping<std::uint64_t> grouping(1000);
  for (int repeat = 0; repeat < 3; ++repeat) {
    grouping.clear();
    for (std::uint64_t key = 0; key < 1000; ++key) EXPECT_EQ(grouping.number(key << 32), key);
    for (std::uint64_t key = 0; key < 1000; ++key) EXPECT_EQ(grouping.number(key << 32), key);
  }
}

}  // namespace
}  // namespace hypgen
