// SPDX-License-Identifier: Apache-2.0
#include "hypgen/leaves/weighted_groups.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace hypgen {
namespace {

// All that the groups know of a model.
struct Line {
  struct State {
    std::int32_t at;
  };
  using Key = std::uint64_t;
};

// Scenarios at places of a line, of which some have ended. Each sees a place.
struct Scenarios {
  std::vector<int> places;
  std::vector<int> seen;
  std::vector<char> ended;
  double deviation = 0.0;  // of the sensor; 0: it sees the place
  int weighed = 0;

  explicit Scenarios(const std::vector<int>& at) : places(at), seen(at), ended(at.size(), 0) {}

  bool part(WeightedGroups<Line>& groups, bool alike_count = true) {
    return groups.make(
        places.size(), [&](std::size_t i) { return ended[i] != 0; },
        [&](std::size_t i, std::size_t j) { return alike_count && places[i] == places[j]; },
        [&](std::size_t i) { return static_cast<std::uint64_t>(seen[i] + 1000); },
        [&](std::size_t i, std::uint64_t key, Line::State&) {
          ++weighed;
          const double far = static_cast<double>(key) - 1000.0 - places[i];
          return deviation > 0.0 ? std::exp(-0.5 * far * far / (deviation * deviation))
                 : far == 0.0    ? 1.0
                                 : 0.0;
        },
        [](std::size_t) { return false; });
  }
};

std::uint64_t shares_of(const WeightedGroups<Line>& groups, std::size_t scenario) {
  std::uint64_t sum = 0;
  for (std::uint32_t g = 0; g < groups.count(); ++g) sum += groups.share(g, scenario);
  return sum;
}

TEST(WeightedGroups, AreThoseThatSeeTheSameWhereASensorHasNoNoise) {
  Scenarios line({3, 1, 3, 2, 1, 3, 9, 9});
  line.ended[6] = line.ended[7] = 1;
  WeightedGroups<Line> groups(8);
  ASSERT_TRUE(line.part(groups));
  ASSERT_EQ(groups.count(), 3U);
  for (std::uint32_t g = 0; g < 3; ++g) {
    for (std::size_t i = 0; i < 6; ++i) {
      const bool together = line.places[i] == line.places[groups.first(g)];
      EXPECT_EQ(groups.share(g, i), together ? kWholeShare : 0U);
      if (together) {
        EXPECT_EQ(groups.likeliest(i), g);
      }
    }
    EXPECT_EQ(groups.named(groups.first(g)), g);
  }
  EXPECT_EQ(groups.named(6), groups.count()) << "it has ended";
}

TEST(WeightedGroups, HoldAllScenariosWhereMoreIsSeenThanIsDrawn) {
  std::vector<int> places;
  for (int i = 0; i < 64; ++i) places.push_back(i);
  Scenarios line(places);
  WeightedGroups<Line> groups(64);
  ASSERT_TRUE(line.part(groups));
  EXPECT_EQ(groups.count(), 64U);
  for (std::size_t i = 0; i < 64; ++i) EXPECT_EQ(shares_of(groups, i), kWholeShare);
}

TEST(WeightedGroups, ShareScenariosByHowLikelyTheirObservationsAre) {
  Scenarios line({0, 0, 0, 0, 4, 4, 4, 4});
  line.seen = {0, 0, 0, 0, 4, 4, 4, 4};
  line.deviation = 2.0;
  WeightedGroups<Line> groups(8);
  ASSERT_TRUE(line.part(groups));
  ASSERT_EQ(groups.count(), 2U);
  // The sensor is coarser: it sees 0 or 4, as likely for each place as their densities are.
  const double other = std::exp(-0.5 * 4.0), expected = 1.0 / (1.0 + other);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(shares_of(groups, i), kWholeShare);
    EXPECT_NEAR(groups.share(i < 4 ? 0 : 1, i) / static_cast<double>(kWholeShare), expected, 1e-4);
  }
}

TEST(WeightedGroups, AreOneWhereTheirBeliefsAreAboutTheSame) {
  Scenarios line({0, 0, 0, 0, 1, 1, 1, 1});
  line.deviation = 100.0;
  WeightedGroups<Line> groups(8);
  ASSERT_TRUE(line.part(groups));
  EXPECT_EQ(groups.count(), 1U);
}

TEST(WeightedGroups, DoNotDependOnWhatIsAlike) {
  Scenarios line({0, 5, 0, 5, 7, 0, 7, 5, 0, 0, 5, 7, 7, 5, 0, 1});
  line.seen = {1, 4, 0, 6, 7, -1, 8, 5, 2, 0, 3, 6, 9, 5, 1, 0};
  line.deviation = 1.5;
  WeightedGroups<Line> one(16), other(16);
  ASSERT_TRUE(line.part(one));
  const int weighed = line.weighed;
  ASSERT_TRUE(line.part(other, false));
  EXPECT_GT(line.weighed - weighed, 2 * weighed);
  ASSERT_EQ(one.count(), other.count());
  for (std::uint32_t g = 0; g < one.count(); ++g) {
    EXPECT_EQ(one.first(g), other.first(g));
    for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(one.share(g, i), other.share(g, i));
  }
}

TEST(WeightedGroups, DrawScenariosByTheirShares) {
  Scenarios line({0, 0, 0, 0, 4, 4, 4, 4, 4});
  line.deviation = 2.0;
  line.ended[8] = 1;
  WeightedGroups<Line> groups(9);
  ASSERT_TRUE(line.part(groups));
  constexpr std::size_t kDrawn = 1000;
  for (const std::uint32_t word : {0U, 1U << 31, UINT32_MAX}) {
    std::vector<int> times(9, 0);
    std::size_t next = 0;
    groups.draw(Alone{}, 0, kDrawn, word, [&](std::size_t i, std::size_t scenario) {
      EXPECT_EQ(i, next++);
      ++times[scenario];
    });
    EXPECT_EQ(next, kDrawn);
    double total = 0.0;
    for (std::size_t i = 0; i < 8; ++i) total += groups.share(0, i);
    for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(times[i], kDrawn * groups.share(0, i) / total, 1.0);
    EXPECT_EQ(times[8], 0);
  }
}

TEST(WeightedGroups, AreNoneWhereAllHaveEnded) {
  Scenarios line({1, 2});
  line.ended = {1, 1};
  WeightedGroups<Line> groups(2);
  ASSERT_TRUE(line.part(groups));
  EXPECT_EQ(groups.count(), 0U);
}

TEST(Spread, IsTheSumOverTheRootsScenarios) {
  EXPECT_EQ(spread(12, 3 * kScenarioMass, 4), 9);  // a mean of 3, for three scenarios
  EXPECT_EQ(spread(-1, kScenarioMass, 2), -1);     // rounded down
  EXPECT_EQ(spread(1, kScenarioMass, 2), 0);
  const WideSum largest = (WideSum{1} << 47) * (1 << 14) * kWholeShare;
  EXPECT_EQ(spread(largest, std::uint64_t{kScenarioMass} << 14, std::uint64_t{kWholeShare} << 14),
            std::int64_t{1} << 61);
}

}  // namespace
}  // namespace hypgen
