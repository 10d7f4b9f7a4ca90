// SPDX-License-Identifier: Apache-2.0
// Every outcome of a draw, once, with the probability that the density gives.
#include "hypgen/random/enumerating_draws.hpp"

#include <gtest/gtest.h>

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
