// SPDX-License-Identifier: Apache-2.0
#include "hypgen/model/key.hpp"

#include <gtest/gtest.h>

#include "hypgen/leaves/grouping.hpp"

namespace hypgen {
namespace {

TEST(Key, DigitsComeBackInOrder) {
  using Key = WideKey<4>;
  constexpr std::uint64_t kSizes[] = {2, 1, std::uint64_t{1} << 32, 7, std::uint64_t{1} << 32, 3, 64};
  for (const bool largest : {false, true}) {
    KeyWriter<Key> writer;
    for (int round = 0; round < 2; ++round) {
      for (const std::uint64_t size : kSizes) writer.put(largest ? size - 1 : size / 3, size);
    }
    const Key key = writer.key();
    KeyReader reader(words_of(key));
    for (int round = 0; round < 2; ++round) {
      for (const std::uint64_t size : kSizes) EXPECT_EQ(reader.take(size), largest ? size - 1 : size / 3);
    }
  }
}

TEST(Key, AWordIsFilledToTheLastValue) {
  KeyCursor cursor;
  for (int i = 0; i < 64; ++i) EXPECT_FALSE(cursor.advance(2)) << i;
  EXPECT_FALSE(cursor.advance(1));
  EXPECT_TRUE(cursor.advance(2));
  EXPECT_EQ(cursor.word(), 1U);
  EXPECT_EQ(cursor.place(), 1U);
}

TEST(Key, WordsMakeTheSameKey) {
  const WideKey<3> key{{5, 0, UINT64_MAX}};
  EXPECT_TRUE(key_from<WideKey<3>>(words_of(key)) == key);
  const std::uint64_t narrow = 9;
  EXPECT_EQ(key_from<std::uint64_t>(words_of(narrow)), narrow);
}

TEST(Key, EveryWordCountsInAGroup) {
  Grouping<WideKey<3>> grouping(1000);
  grouping.clear();
  std::uint32_t number = 0;
  for (std::uint64_t word = 0; word < 3; ++word) {
    for (std::uint64_t value = 1; value <= 300; ++value) {
      WideKey<3> key{};
      key.words[word] = value << 40;
      EXPECT_EQ(grouping.number(key), number);
      EXPECT_EQ(grouping.number(key), number++);
    }
  }
}

}  // namespace
}  // namespace hypgen
