// SPDX-License-Identifier: Apache-2.0
#include "hypgen/leaves/draw_cache.hpp"

#include <gtest/gtest.h>

namespace hypgen {
namespace {

// More sites than have room, two searches, steps on both sides of a run.
void expect_words_of_the_stream(DrawCache& cache) {
  for (std::uint64_t number = 0; number < 2; ++number) {
    const StreamKey key = derive(5, StreamKind::kPlan, number);
    cache.begin_search(key, 100);
    for (std::uint32_t scenario = 0; scenario < 4; ++scenario) {
      for (const std::uint32_t step : {40U, 0U, 15U, 16U, 31U, 32U}) {
        SearchDraws cached(cache, scenario, step);
        for (std::uint32_t site = 0; site < 8; ++site) {
          for (std::uint32_t index = 0; index < 9; ++index) {
            PhiloxDraws fresh(key, 100 + scenario, step);
            const std::uint32_t expected = fresh.word(site * 0x9E3779B9U, index);
            ASSERT_EQ(cached.word(site * 0x9E3779B9U, index), expected);
          }
        }
      }
    }
  }
}

TEST(DrawCache, GivesTheWordsOfTheStream) {
  DrawCache cache(4, 41);
  expect_words_of_the_stream(cache);
}

TEST(DrawCache, WithLittleMemoryCoversFewerSteps) {
  const std::size_t steps = DrawCache::steps_within(DrawCache::bytes(4, 41) - 1, 4, 41);
  EXPECT_EQ(steps, 32U);
  EXPECT_EQ(DrawCache::steps_within(DrawCache::bytes(4, 41), 4, 41), 41U);
  for (const std::size_t covered : {steps, std::size_t{0}}) {
    DrawCache cache(4, covered);
    expect_words_of_the_stream(cache);
  }
}

}  // namespace
}  // namespace hypgen
