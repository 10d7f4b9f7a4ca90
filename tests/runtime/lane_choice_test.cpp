// SPDX-License-Identifier: Apache-2.0
#include "hypgen/leaves/lane_choice.hpp"

#include <gtest/gtest.h>

namespace hypgen {
namespace {

constexpr std::size_t kRollouts = 1000;
constexpr std::uint64_t kMany = 1'000'000'000;  // steps, each of which costs next to nothing

// Plays the first leaf: of so many steps either way, in as little time.
void play_first(LaneChoice& choice, std::uint64_t alone, std::uint64_t in_lanes) {
  ASSERT_TRUE(choice.takes(kRollouts));
  ASSERT_TRUE(choice.wants_sample());
  choice.begin();
  choice.end_alone(alone);
  EXPECT_EQ(choice.next(kRollouts), 128U);
  choice.begin();
  choice.end_in_lanes(in_lanes);
}

TEST(LaneChoice, TriesFewRolloutsAndPlaysTheRestTheSoonerWay) {
  LaneChoice slower(true), faster(true);
  play_first(slower, kMany, 1);
  EXPECT_EQ(slower.next(872), 0U);
  play_first(faster, 1, kMany);
  EXPECT_EQ(faster.next(872), 872U);
}

TEST(LaneChoice, TriesAgainNowAndThen) {
  LaneChoice choice(true);
  play_first(choice, kMany, 1);
  for (int leaf = 1; leaf < 256; ++leaf) ASSERT_FALSE(choice.takes(kRollouts));
  EXPECT_TRUE(choice.takes(kRollouts));
  EXPECT_EQ(choice.next(kRollouts), 128U);
}

TEST(LaneChoice, MeasuresEachSizeOfLeaves) {
  LaneChoice choice(true);
  play_first(choice, kMany, 1);
  EXPECT_TRUE(choice.takes(10));
  EXPECT_EQ(choice.next(10), 10U);
}

TEST(LaneChoice, TakesAllWhereNothingIsMeasured) {
  LaneChoice choice(false);
  EXPECT_TRUE(choice.takes(3));
  EXPECT_FALSE(choice.wants_sample());
  EXPECT_EQ(choice.next(3), 3U);
}

}  // namespace
}  // namespace hypgen
