#include "hypgen/draw_cache.hpp"

#include <gtest/gtest.h>

namespace hypgen {
namespace {

// More sites than have room, two searches, steps on both sides of a run.
TEST(DrawCache, GivesTheWordsOfTheStream) {
  DrawCache cache(4, 40);
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

}  // namespace
}  // namespace hypgen
