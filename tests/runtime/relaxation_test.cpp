// SPDX-License-Identifier: Apache-2.0
// Tables of small models: what they hold, and that filling one ends.
#include "hypgen/bounds/relaxation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "hypgen/random/distributions.hpp"

namespace hypgen::relaxation {
namespace {

// One state, in which every step costs as much as params say and draws as many words.
struct Params {
  double cost;
  std::uint32_t words;
};
struct Fixed {};
struct State {};

StepResult step(const Params& params, const Fixed&, const State&, int, exact::EnumeratingDraws& draws,
                State&) {
  StepResult result{};
  for (std::uint32_t i = 0; i < params.words; ++i) dist::bernoulli(draws.word(1, i), 0.5F);
  result.reward = math::to_fixed(static_cast<float>(-params.cost));
  return result;
}

float table_of(const Params& params, bool may_stop) {
  static constexpr int kActions[] = {0};
  float table = 0.0F;
  const Group<Params, Fixed, State> groups[] = {
      {1,
       {kActions, 1},
       [](std::int32_t, Fixed&, State&) {},
       [](const Fixed&, const State&) { return std::int32_t{0}; },
       [](const Params&, const Fixed&, const State&, int) { return true; },
       step,
       nullptr,
       &table}};
  fill(groups, params, 0.9, may_stop);
  return table;
}

TEST(Relaxation, HoldsTheValueRoundedUp) {
  const float value = table_of({1.0, 2}, false);
  EXPECT_GE(value, -10.0F);
  EXPECT_LT(value, -9.999F);
}

// With a horizon an episode may end before it has cost as much as one without end.
TEST(Relaxation, MayStop) { EXPECT_GE(table_of({1.0, 2}, true), 0.0F); }

// Each entry after the first is too small to change the sum of floats.
TEST(Relaxation, ASumOfManyTablesIsNoLessThanTheSumOfTheirValues) {
  for (const std::size_t groups : {2, 16, 17, 64, 256}) {
    float sum = rounded_up(1.0, groups);
    double exact = 1.0;
    for (std::size_t i = 1; i < groups; ++i) {
      const double value = 0.999 * 0x1p-24;
      sum += rounded_up(value, groups);
      exact += value;
    }
    EXPECT_GE(static_cast<double>(sum), exact) << groups << " groups";
  }
}

// 2^40 paths through the draws of one step.
TEST(Relaxation, GivesUpOnTooManyPaths) { EXPECT_TRUE(std::isinf(table_of({1.0, 40}, false))); }

}  // namespace
}  // namespace hypgen::relaxation
