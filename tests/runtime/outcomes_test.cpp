// SPDX-License-Identifier: Apache-2.0
// What states of a small decision process are worth.
#include <gtest/gtest.h>

#include <vector>

#include "hypgen/bounds/small_process.hpp"

namespace hypgen::relaxation {
namespace {

// Adds a choice of the state being added, with one outcome, or none where it ends the episode.
void choose(Outcomes& outcomes, double reward, std::int32_t next, double probability) {
  outcomes.reward.push_back(reward);
  if (next >= 0) {
    outcomes.next.push_back(next);
    outcomes.probability.push_back(probability);
  }
  outcomes.first_outcome.push_back(static_cast<std::int64_t>(outcomes.next.size()));
}

void end_state(Outcomes& outcomes) {
  outcomes.first_choice.push_back(static_cast<std::int64_t>(outcomes.reward.size()));
}

// State 0 pays for ever or goes on to 1, which earns 4 half of the time and stays; 2 has no legal action.
Outcomes example() {
  Outcomes outcomes;
  choose(outcomes, -1.0, 0, 1.0);
  choose(outcomes, -2.0, 1, 1.0);
  end_state(outcomes);
  choose(outcomes, 2.0, 1, 0.5);
  end_state(outcomes);
  end_state(outcomes);
  choose(outcomes, -1.0, 3, 1.0);
  end_state(outcomes);
  return outcomes;
}

TEST(Outcomes, WorthIsTheOptimalValue) {
  const std::vector<double> values = worth(example(), 0.9, false);
  const double one = 2.0 / (1.0 - 0.45);
  EXPECT_NEAR(values[1], one, 1e-6);
  EXPECT_NEAR(values[0], -2.0 + 0.9 * one, 1e-6);
  EXPECT_EQ(values[2], 0.0);
  EXPECT_NEAR(values[3], -10.0, 1e-6);
}

TEST(Outcomes, WorthIsNeverTooLittle) {
  const std::vector<double> values = worth(example(), 0.9, false);
  EXPECT_GE(values[1], 2.0 / (1.0 - 0.45) - 1e-12);
  EXPECT_GE(values[3], -10.0 - 1e-12);
}

TEST(Outcomes, AnEpisodeMayEndBeforeItPays) {
  const std::vector<double> values = worth(example(), 0.9, true);
  EXPECT_NEAR(values[3], 0.0, 1e-6);
  EXPECT_NEAR(values[1], 2.0 / (1.0 - 0.45), 1e-6);
}

TEST(Outcomes, WhatIsEarnedIsNeverTooMuch) {
  Outcomes outcomes;
  choose(outcomes, -1.0, 1, 1.0);
  end_state(outcomes);
  choose(outcomes, 2.0, 0, 1.0);
  end_state(outcomes);
  const std::vector<double> values = earned(outcomes, 0.9);
  const double first = (-1.0 + 0.9 * 2.0) / (1.0 - 0.81);
  EXPECT_NEAR(values[0], first, 1e-6);
  EXPECT_LE(values[0], first + 1e-12);
  EXPECT_LE(values[1], 2.0 + 0.9 * first + 1e-12);
}

}  // namespace
}  // namespace hypgen::relaxation
