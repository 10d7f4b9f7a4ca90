// SPDX-License-Identifier: Apache-2.0
// Every outcome of a draw, once, with the probability that the density gives.
#include "hypgen/random/enumerating_draws.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "hypgen/random/distributions.hpp"

namespace hypgen::exact {
namespace {

constexpr double kTolerance = 1e-12;

// The probability of each outcome of `run`; all add up to 1.
template <class Run>
auto law_of(const Run& run) {
  EnumeratingDraws draws;
  std::map<decltype(run(draws)), double> law;
  double total = 0.0;
  do {
    const auto outcome = run(draws);
    law[outcome] += draws.probability();
    total += draws.probability();
  } while (draws.next());
  EXPECT_NEAR(total, 1.0, kTolerance);
  return law;
}

// Whether a sampler of one word gives each of low .. high as often as its density says.
template <class Sample, class Density>
void expect_density(const Sample& sample, const Density& density, int low, int high) {
  auto law = law_of([&](EnumeratingDraws& draws) { return static_cast<int>(sample(draws.word(7, 0))); });
  for (int value = low; value <= high; ++value) {
    EXPECT_NEAR(law[value], density(value), kTolerance) << value;
    law.erase(value);
  }
  EXPECT_TRUE(law.empty());
}

TEST(EnumeratingDraws, GivesBothSidesOfABernoulli) {
  for (const float p : {0.0F, 0.15F, 0.5F, 1.0F, 1.5F, -1.0F}) {
    expect_density([&](auto word) { return dist::bernoulli(word, p); },
                   [&](int value) { return dist::bernoulli_density(value != 0, p); }, 0, 1);
  }
}

// Pieces of 2^32 words differ by one word, which the density of a uniform draw leaves out.
TEST(EnumeratingDraws, CountsTheWordsOfEqualPieces) {
  for (const int count : {1, 2, 3, 7, 1000}) {
    const auto law = law_of([&](EnumeratingDraws& draws) { return dist::uniform(draws.word(7, 0), count); });
    ASSERT_EQ(law.size(), static_cast<std::size_t>(count));
    for (const auto& [value, probability] : law) {
      EXPECT_NEAR(probability, 1.0 / count, 1.0 / dist::kWords);
    }
    const auto words = static_cast<std::uint64_t>(law.at(0) * dist::kWords);
    EXPECT_EQ(dist::uniform(static_cast<std::uint32_t>(words - 1), count), 0);
    EXPECT_EQ(dist::uniform(static_cast<std::uint32_t>(words), count), count == 1 ? 0 : 1);
  }
}

TEST(EnumeratingDraws, GivesAllIntegersOfARange) {
  const auto sample = [](int low, int high) {
    return [=](EnumeratingDraws& draws) { return dist::uniform_int(draws.word(7, 0), low, high, -2, 5); };
  };
  EXPECT_EQ(law_of(sample(-1, 3)).size(), 5U);
  EXPECT_EQ(law_of(sample(3, 1)).size(), 1U);
  const auto law = law_of(sample(-4, 7));
  EXPECT_EQ(law.size(), 8U);
  EXPECT_NEAR(law.at(-2), dist::uniform_int_density(-2, -4, 7, -2, 5), 1e-9);
  EXPECT_NEAR(law.at(5), dist::uniform_int_density(5, -4, 7, -2, 5), 1e-9);
}

TEST(EnumeratingDraws, GivesANoisyValue) {
  for (const int count : {1, 2, 5}) {
    const auto law = law_of(
        [&](EnumeratingDraws& draws) { return dist::noisy(draws.word(7, 0), 1 % count, 0.7F, count); });
    for (const auto& [value, probability] : law) {
      EXPECT_NEAR(probability, dist::noisy_density(value == 1 % count, 0.7F, count), 1e-9);
    }
    EXPECT_EQ(law.size(), static_cast<std::size_t>(count));
  }
}

TEST(EnumeratingDraws, GivesCounts) {
  for (const float mean : {0.0F, 0.4F, 3.0F}) {
    expect_density([&](auto word) { return dist::poisson(word, mean, {}, 0, 12); },
                   [&](int k) { return dist::poisson_density(k, mean, {}, 0, 12); }, 0, 12);
    const dist::Truncation truncation{1, 4, true};
    expect_density([&](auto word) { return dist::poisson(word, mean, truncation, 1, 4); },
                   [&](int k) { return dist::poisson_density(k, mean, truncation, 1, 4); }, 1, 4);
  }
  for (const float p : {0.2F, 0.9F}) {  // 0.9: counted from the other end, with a mirrored word
    expect_density([&](auto word) { return dist::binomial(word, 6, p, {}, 0, 8); },
                   [&](int k) { return dist::binomial_density(k, 6, p, {}, 0, 8); }, 0, 8);
  }
}

TEST(EnumeratingDraws, GivesTheBinsOfContinuousLaws) {
  const auto expect_bins = [](const auto& bins, int count) {
    expect_density([&](auto word) { return bins.draw(word); }, [&](int bin) { return bins.density(bin); }, 0,
                   count - 1);
  };
  expect_bins(dist::Bins(dist::Normal{2.0F, 1.5F}, 0.0F, 5.0F, 10), 10);
  expect_bins(dist::Bins(dist::Normal{40.0F, 0.1F}, 0.0F, 5.0F, 10), 10);
  expect_bins(dist::Bins(dist::RecurringNormal{2.0F, 1.5F}, 0.0F, 5.0F, 10), 10);
  expect_bins(dist::Bins(dist::Exponential(2.0F), 0.0F, 5.0F, 7), 7);
  expect_bins(dist::Bins(dist::Truncated(dist::Normal{2.0F, 1.5F}, 1.0F, 3.0F), 0.0F, 5.0F, 5), 5);
}

// As generated code decides a table of three entries, by position and by comparison.
TEST(EnumeratingDraws, GivesTheEntriesOfATable) {
  const auto by_position = [](EnumeratingDraws& draws) {
    const auto word = draws.word(7, 0);
    return dist::reached(word, 0x40000000U) + dist::reached(word, 0x60000000U);
  };
  const auto by_comparison = [](EnumeratingDraws& draws) {
    const auto word = draws.word(7, 0);
    const std::uint64_t below = math::threshold(0.25F), below_1 = below + math::threshold(0.125F);
    if (word < below) return 0;
    return word < below_1 ? 1 : 2;
  };
  const std::map<int, double> expected = {{0, 0.25}, {1, 0.125}, {2, 0.625}};
  EXPECT_EQ(law_of(by_position), expected);
  EXPECT_EQ(law_of(by_comparison), expected);
}

// A draw of 63 bits has the law of its density, to the last of them; `bits` are driven by word and second word.
template <class Sample, class Density>
void expect_fine_density(const Sample& sample, const Density& density, int low, int high) {
  auto law =
      law_of([&](EnumeratingDraws& draws) { return static_cast<int>(sample(dist::fine(draws, 7, 0))); });
  for (int value = low; value <= high; ++value) {
    EXPECT_DOUBLE_EQ(law[value], density(value)) << value;
  }
}

// The words of 63 bits.
struct GivenBits {
  std::uint64_t bits;

  std::uint32_t word(std::uint32_t /*site*/, std::uint32_t index) {
    return static_cast<std::uint32_t>((index & kSecondWord) == 0 ? bits >> 31 : bits << 1);
  }
};

// What a sampler gives for them.
template <class Sample>
auto drawn(const Sample& sample, std::uint64_t bits) {
  GivenBits draws{bits};
  return static_cast<int>(sample(dist::fine(draws, 7, 0)));
}

TEST(EnumeratingDraws, GivesRareOutcomes) {
  for (const double p : {1e-15, 1e-10, 0.0, 1e-3, 0.25, 0.9999, 1.0}) {
    const std::uint64_t mass = dist::mass(static_cast<float>(p));
    const auto sample = [=](const auto& word) { return dist::bernoulli(word, mass); };
    expect_fine_density(sample, [=](int value) { return dist::bernoulli_density(value != 0, mass); }, 0, 1);
    if (mass == 0 || mass == dist::kWhole) continue;
    EXPECT_EQ(drawn(sample, mass - 1), 1);
    EXPECT_EQ(drawn(sample, mass), 0);
    const std::uint64_t complement = dist::mass(1.0F - static_cast<float>(p), static_cast<float>(p));
    if (p < 1e-9) {
      EXPECT_EQ(complement, dist::kWhole - mass);
    }
  }
}

TEST(EnumeratingDraws, GivesRareNoise) {
  for (const double q : {1e-15, 1e-10, 1e-5, 0.25, 0.9}) {
    for (const int count : {1, 2, 5, 1000}) {
      const std::uint64_t mass = dist::mass(1.0F - static_cast<float>(q), static_cast<float>(q));
      const int value = 1 % count;
      const auto law = law_of(
          [&](EnumeratingDraws& draws) { return dist::noisy(dist::fine(draws, 7, 0), value, mass, count); });
      ASSERT_EQ(law.size(), static_cast<std::size_t>(count));
      std::uint64_t end = mass;
      for (const auto& [drawn_value, probability] : law) {
        const double density = dist::noisy_density(drawn_value == value, mass, count);
        EXPECT_NEAR(probability, density, density * 1e-3 + 0x1p-63);
        if (drawn_value == value) continue;
        const auto sample = [&](const auto& word) { return dist::noisy(word, value, mass, count); };
        end += static_cast<std::uint64_t>(std::ldexp(probability, 63));
        EXPECT_EQ(drawn(sample, end - 1), drawn_value);
        if (drawn_value < count - 1) {
          EXPECT_GT(drawn(sample, end), drawn_value);
        }
      }
    }
  }
}

// As generated code decides a table whose entries are known when a model runs.
TEST(EnumeratingDraws, GivesTheLikeliestWhatTheOthersLeave) {
  const auto expect_law = [](std::vector<float> p) {
    std::uint64_t masses[] = {dist::mass(p[0]), dist::mass(p[1]), dist::mass(p[2])};
    dist::settle(masses);
    const auto sample = [&](const auto& word) {
      const std::uint64_t below = masses[0], below_2 = dist::up_to(below, masses[1]);
      return word.below(below) ? 0 : word.below(below_2) ? 1 : 2;
    };
    const auto density = [&](int value) {
      dist::Masses sums;
      for (int i = 0; i < 2; ++i) sums.take(masses[i], value == i);
      sums.take_rest(value == 2);
      return sums.density();
    };
    expect_fine_density(sample, density, 0, 2);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(density(i), p[i], 1e-4 * p[i] + 0x1p-63) << i;
    if (p[2] > 0.0F) {
      EXPECT_EQ(drawn(sample, dist::kWhole - 1), 2);
    }
    if (p[2] > 0.0F && p[2] < 1e-3F) {
      EXPECT_EQ(drawn(sample, dist::kWhole - masses[2]), 2);
      EXPECT_EQ(drawn(sample, dist::kWhole - masses[2] - 1), masses[1] == 0 ? 0 : 1);
    }
  };
  expect_law({1.0F, 1e-10F, 1e-15F});
  expect_law({1e-15F, 1.0F, 1e-10F});
  expect_law({1e-15F, 1e-10F, 1.0F});
  expect_law({0.7F, 0.3F, 1e-12F});
  expect_law({0.7F, 0.3F, 0.0F});
  expect_law({0.5F, 0.25F, 0.25F});
}

TEST(EnumeratingDraws, WeighsRareCandidates) {
  const std::vector<float> weights = {3.0F, 1e-15F, 0.0F, 5.0F, 1e-9F, 2.0F};
  dist::WeightSum sum;
  int likeliest = 0;
  for (int i = 0; i < 6; ++i) {
    if (sum.add(weights[i])) likeliest = i;
  }
  ASSERT_EQ(likeliest, 3);
  const auto law = law_of([&](EnumeratingDraws& draws) {
    const auto word = dist::fine(draws, 7, 0);
    dist::WeightWalk walk(sum);
    for (int i = 0; i < 6; ++i) {
      if (walk.add(weights[i]) && word.below(walk.until())) return i;
    }
    return likeliest;
  });
  ASSERT_EQ(law.size(), 5U);
  for (const auto& [i, probability] : law) {
    const double expected = static_cast<double>(weights[i]) / (10.0 + 1e-9 + 1e-15);
    EXPECT_NEAR(probability, expected, 1e-3 * expected) << i;
  }
}

TEST(EnumeratingDraws, ReadsADrawTwiceAsOne) {
  const auto law = law_of([](EnumeratingDraws& draws) {
    const bool first = dist::bernoulli(draws.word(7, 3), 0.25F);
    const bool other = dist::bernoulli(draws.word(7, 4), 0.5F);
    return std::pair(first == dist::bernoulli(draws.word(7, 3), 0.25F), other);
  });
  EXPECT_EQ(law, (std::map<std::pair<bool, bool>, double>{{{true, false}, 0.5}, {{true, true}, 0.5}}));
}

TEST(EnumeratingDraws, FollowsDrawsThatDependOnOthers) {
  std::vector<int> paths;
  EnumeratingDraws draws;
  do {
    draws.word(9, 9);  // which nobody compares
    const int count = 1 + dist::uniform(draws.word(7, 0), 2);
    int outcome = 10 * count;
    for (int i = 0; i < count; ++i) {
      outcome += dist::bernoulli(draws.word(8, static_cast<std::uint32_t>(i)), 0.5F) ? 1 : 0;
    }
    paths.push_back(outcome);
    EXPECT_EQ(draws.probability(), count == 1 ? 0.25 : 0.125);
  } while (draws.next());
  EXPECT_EQ(paths, (std::vector<int>{11, 10, 22, 21, 21, 20}));
  draws.start();
  EXPECT_EQ(draws.probability(), 1.0);
}

}  // namespace
}  // namespace hypgen::exact
