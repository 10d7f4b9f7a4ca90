// SPDX-License-Identifier: Apache-2.0
#include "hypgen/belief/first_draws.hpp"

#include <gtest/gtest.h>

#include "factored_models.hpp"
#include "hypgen/belief/factored_belief.hpp"
#include "hypgen/belief/particle_belief.hpp"

namespace hypgen::testing {
namespace {

struct Taken {
  std::vector<std::uint32_t> candidates;
  std::vector<double> weights;
  bool is_explained = false;
};

Taken taken(const FirstDraws& first, std::size_t column, std::uint32_t word = 0) {
  Taken result;
  result.is_explained =
      first.choose(column, word, [&](std::uint32_t i, std::uint32_t candidate, double weight) {
        EXPECT_EQ(i, result.candidates.size());
        result.candidates.push_back(candidate);
        result.weights.push_back(weight);
      });
  return result;
}

TEST(FirstDraws, KeepsOneRoundWithItsWeightsWhereThatIsEnough) {
  FirstDraws first(4, 1);
  for (const double likelihood : {0.2, 0.1, 0.1, 0.0}) first.add(&likelihood);
  EXPECT_FALSE(first.wants_more());
  const Taken found = taken(first, 0);
  EXPECT_EQ(found.candidates, (std::vector<std::uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(found.weights, (std::vector<double>{0.5, 0.25, 0.25, 0.0}));
}

TEST(FirstDraws, SamplesWhatExplainsFromFurtherRounds) {
  FirstDraws first(4, 2);
  std::uint32_t rounds = 0;
  do {
    for (int i = 0; i < 4; ++i) {
      const double likelihoods[] = {i == 2 ? 1.0 : 0.0, 1.0};
      first.add(likelihoods);
    }
    ++rounds;
  } while (first.wants_more());
  EXPECT_EQ(rounds, 2U);  // with two of eight candidates the first column has half of its four particles
  EXPECT_EQ(taken(first, 0).candidates, (std::vector<std::uint32_t>{2, 2, 6, 6}));
  EXPECT_EQ(taken(first, 0, 0xFFFFFFFF).candidates, (std::vector<std::uint32_t>{2, 2, 6, 6}));
  EXPECT_EQ(taken(first, 1).candidates, (std::vector<std::uint32_t>{0, 2, 4, 6}));
  EXPECT_EQ(taken(first, 1).weights, std::vector<double>(4, 0.25));
}

TEST(FirstDraws, StopsLookingForWhatNothingExplains) {
  FirstDraws first(4, 1);
  std::uint32_t rounds = 0;
  do {
    const double none = 0.0;
    for (int i = 0; i < 4; ++i) first.add(&none);
    ++rounds;
  } while (first.wants_more());
  EXPECT_EQ(rounds, 16U);
  const Taken found = taken(first, 0);
  EXPECT_FALSE(found.is_explained);
  EXPECT_EQ(found.candidates, (std::vector<std::uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(found.weights, std::vector<double>(4, 0.25));
}

constexpr std::int32_t key_of(int coin, int level) { return coin * 12 + level + 1; }

// A belief of the coin (variable 0) and the level (variable 1) that begins with a key.
template <class Kind>
struct Begun {
  Begun(std::int32_t key, std::size_t particles) : belief(params, 7, particles) {
    status = belief.init(&key, 0);
  }
  CoinSeenFirst::Params params;
  Kind belief;
  Status status;
};

template <class Kind>
class FirstBelief : public ::testing::Test {};
using Kinds = ::testing::Types<ParticleBelief<CoinSeenFirst>, FactoredBelief<CoinSeenFirst>>;
TYPED_TEST_SUITE(FirstBelief, Kinds);

TYPED_TEST(FirstBelief, IsConditionedOnWhatIsSeenFirst) {
  const Begun<TypeParam> begun(key_of(1, 4), 40000);
  EXPECT_EQ(begun.status, Status::kOk);
  EXPECT_NEAR(begun.belief.marginal(0, 1), 0.8, 0.02);
  for (int level = 0; level <= 9; ++level) {
    EXPECT_NEAR(begun.belief.marginal(1, level), CoinSeenFirst::level_density(level, 4), 0.02) << level;
  }
}

TYPED_TEST(FirstBelief, HasItsFullNumberOfParticlesOfWhatIsRare) {
  const Begun<TypeParam> begun(key_of(1, -1), 40);  // a level of 0, read too low
  EXPECT_EQ(begun.status, Status::kOk);
  EXPECT_DOUBLE_EQ(begun.belief.marginal(1, 0), 1.0);
  EXPECT_GE(begun.belief.effective_sample_size(), 20.0);
}

TYPED_TEST(FirstBelief, IsThatOfTheInitsWhereNothingExplainsWhatIsSeen) {
  Begun<TypeParam> begun(key_of(2, 4), 4000);
  EXPECT_EQ(begun.status, Status::kImpossibleObservation);
  EXPECT_NEAR(begun.belief.effective_sample_size(), 4000.0, 1e-6);
  const std::int32_t seen = key_of(0, 9);
  EXPECT_EQ(begun.belief.init(&seen, 1), Status::kOk);
  EXPECT_NEAR(begun.belief.marginal(0, 0), 0.8, 0.05);
}

}  // namespace
}  // namespace hypgen::testing
