// SPDX-License-Identifier: Apache-2.0
#include "hypgen/random/philox.hpp"

#include <gtest/gtest.h>

namespace hypgen {
namespace {

void expect_block(const PhiloxBlock& block, std::uint32_t a, std::uint32_t b, std::uint32_t c,
                  std::uint32_t d) {
  EXPECT_EQ(block.words[0], a);
  EXPECT_EQ(block.words[1], b);
  EXPECT_EQ(block.words[2], c);
  EXPECT_EQ(block.words[3], d);
}

// Known answers of the Random123 library.
TEST(Philox, KnownAnswers) {
  expect_block(philox(0, 0, {{0, 0, 0, 0}}), 0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8);
  expect_block(philox(0xffffffff, 0xffffffff, {{0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}}), 0x408f276d,
               0x41c83b0e, 0xa20bc7c6, 0x6d5451fd);
  expect_block(philox(0xa4093822, 0x299f31d0, {{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}}), 0xd16cfe09,
               0x94fdcceb, 0x5001e420, 0x24126ea1);
}

TEST(Philox, DrawsAreAFunctionOfTheirNames) {
  const StreamKey key = derive(7, StreamKind::kPlan, plan_number(3, 5));
  PhiloxDraws draws(key, 11, 2);
  const std::uint32_t first = draws.word(100, 5);
  draws.word(100, 9);
  draws.word(200, 5);
  EXPECT_EQ(draws.word(100, 5), first);
  EXPECT_EQ(first, philox(key.key0, key.key1, {{11, 2, 100, 1}}).words[1]);
}

TEST(Philox, StreamsDiffer) {
  const StreamKey world = derive(1, StreamKind::kWorld, 0), plan = derive(1, StreamKind::kPlan, 0);
  const StreamKey other = derive(2, StreamKind::kWorld, 0), later = derive(1, StreamKind::kPlan, 1);
  EXPECT_NE(world.key0, plan.key0);
  EXPECT_NE(world.key0, other.key0);
  EXPECT_NE(plan.key0, later.key0);
}

TEST(Philox, RecordedDrawsComeInOrder) {
  const std::uint32_t words[] = {4, 5};
  RecordedDraws draws(words, 2);
  EXPECT_EQ(draws.word(9, 9), 4U);
  EXPECT_EQ(draws.word(9, 9), 5U);
  EXPECT_EQ(draws.word(9, 9), 4U);
}

}  // namespace
}  // namespace hypgen
