// SPDX-License-Identifier: Apache-2.0
#include "hypgen/belief/factored_belief.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "factored_models.hpp"
#include "test_solvers.hpp"

namespace hypgen::testing {
namespace {

constexpr std::size_t kParticles = 40000;

std::uint64_t key_of(int coin, int level) { return static_cast<std::uint64_t>(coin * 12 + level + 1); }

struct Fixture {
  explicit Fixture(std::size_t particles = kParticles) : belief(params, 0, particles) {
    belief.init(nullptr, 0);
  }

  Status see(int action, std::uint64_t key) { return belief.update(action, words_of(key)); }

  CoinAndLevel::Params params;
  FactoredBelief<CoinAndLevel> belief;
};

TEST(FactoredBelief, FollowsBayesRuleInEveryFactor) {
  Fixture fixture;
  double coin = 0.5, levels[10];
  std::fill_n(levels, 10, 0.1);
  const int readings[][2] = {{1, 4}, {1, 4}, {0, 5}, {1, 6}, {1, 5}, {1, 7}};
  for (const auto& reading : readings) {
    ASSERT_EQ(fixture.see(0, key_of(reading[0], reading[1])), Status::kOk);
    const double heads = coin * CoinAndLevel::coin_density(1, reading[0]);
    coin = heads / (heads + (1.0 - coin) * CoinAndLevel::coin_density(0, reading[0]));
    double total = 0.0;
    for (int level = 9; level >= 0; --level) {
      const double stays = level == 9 ? 1.0 : 0.5;
      levels[level] = levels[level] * stays + (level > 0 ? 0.5 * levels[level - 1] : 0.0);
      total += levels[level] *= CoinAndLevel::level_density(level, reading[1]);
    }
    EXPECT_NEAR(fixture.belief.marginal(0, 1), coin, 1e-6);  // exact but for the rounding of a float
    for (int level = 0; level <= 9; ++level) {
      levels[level] /= total;
      EXPECT_NEAR(fixture.belief.marginal(1, level), levels[level], 0.02);
    }
  }
}

TEST(FactoredBelief, DrawsFactorsInProportionAndIndependently) {
  Fixture fixture;
  fixture.see(0, key_of(1, 4));
  ScenarioBuffer scenarios;
  fixture.belief.reserve(scenarios, 10000);
  fixture.belief.sample(derive(0, StreamKind::kPlan, 0), 0, 10000, scenarios);
  ASSERT_EQ(scenarios.size(), 10000U);
  std::vector<CoinAndLevel::Fixed> fixed(10000);
  std::vector<CoinAndLevel::State> states(10000);
  scenarios.copy_to(fixed.data(), states.data());
  double heads = 0.0, fours = 0.0, both = 0.0;
  for (const CoinAndLevel::State& state : states) {
    heads += state.words[0];
    fours += state.words[1] == 4;
    both += state.words[0] == 1 && state.words[1] == 4;
  }
  EXPECT_NEAR(heads, 8000.0, 1.0);  // systematic sampling: no noise
  EXPECT_NEAR(fours / 10000.0, fixture.belief.marginal(1, 4), 0.015);
  EXPECT_NEAR(both / fours, 0.8, 0.03);
}

TEST(FactoredBelief, ResamplesAFactorBeforeItsWeightsDegenerate) {
  Fixture fixture(1000);
  EXPECT_NEAR(fixture.belief.effective_sample_size(), 1000.0, 1e-6);
  for (int level = 2; level < 8; ++level) {
    ASSERT_EQ(fixture.see(0, key_of(1, level)), Status::kOk);
    EXPECT_GE(fixture.belief.effective_sample_size(), 499.0);
  }
}

TEST(FactoredBelief, TellsFailuresApartAndStaysAsItWas) {
  Fixture fixture(500);
  EXPECT_EQ(fixture.see(1, key_of(1, 4)), Status::kAllParticlesTerminal);
  ASSERT_EQ(fixture.see(0, key_of(1, 4)), Status::kOk);
  EXPECT_NEAR(fixture.belief.marginal(0, 1), 0.8, 1e-6);
  EXPECT_EQ(fixture.see(0, key_of(1, 9)), Status::kDepletedBelief);
  EXPECT_NEAR(fixture.belief.marginal(0, 1), 0.8, 1e-6);
}

TEST(FactoredBelief, GoesOnFromWhatItCannotExplain) {
  Fixture fixture(500);
  ASSERT_EQ(fixture.see(0, key_of(1, 4)), Status::kOk);
  ASSERT_EQ(fixture.see(0, key_of(1, 9)), Status::kDepletedBelief);
  fixture.belief.propagate(0, words_of(key_of(1, 9)));
  EXPECT_NEAR(fixture.belief.marginal(0, 1), 16.0 / 17.0, 1e-6);  // the coin explains its part
  EXPECT_GT(fixture.belief.marginal(1, 8) + fixture.belief.marginal(1, 9), 0.999);  // the level starts again
  EXPECT_GE(fixture.belief.effective_sample_size(), 250.0);
  EXPECT_EQ(fixture.see(0, key_of(1, 9)), Status::kOk);
}

TEST(FactoredBelief, IsExportedAsASample) {
  Fixture fixture(1000);
  ScenarioBuffer particles;
  std::vector<double> weights;
  fixture.belief.export_particles(particles, weights);
  EXPECT_EQ(particles.size(), 1000U);
  EXPECT_DOUBLE_EQ(weights[0], 0.001);
  EXPECT_FALSE(fixture.belief.import_particles(particles, weights));  // a product is more than a sample of it
}

}  // namespace
}  // namespace hypgen::testing
