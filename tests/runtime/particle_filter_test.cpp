// SPDX-License-Identifier: Apache-2.0
#include "hypgen/belief/particle_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <vector>

#include "test_workers.hpp"

namespace hypgen::testing {
namespace {

constexpr int kSpots = 1000;

double chance(int spot, int reading) { return std::max(0.0, 1.0 - std::abs(spot - reading) / 50.0) / 50.0; }

// `units` things, each of which stands at one of kSpots spots or drifts to the right. A step sees them all
// blurred by up to 50 spots.
template <int units>
struct Standing {
  struct Params {};
  struct Fixed {
    std::uint32_t drifts[units];
  };
  struct State {
    std::uint32_t spots[units];
  };
  using Key = std::vector<int>;
  struct Evidence {
    State next;
    int readings[units];
  };
  static constexpr int kUnits = units;
  static constexpr int kValues = 2;
  static constexpr int kFirstWords = 16;
  static constexpr bool kCountsApart = false;
  static constexpr bool kSeesFirst = false;
  static constexpr bool kRedraws = false;
  static constexpr bool kMovesValues = false;

  static void see(const Params&, const Fixed&, const State& state, int, const Key& key, Evidence& seen) {
    seen.next = state;
    std::copy(key.begin(), key.end(), seen.readings);
  }
  static double weigh_start(const Params&, int, const Fixed&, const State&) { return 1.0; }
  static const State& visible(const Evidence& seen) { return seen.next; }
  template <class D>
  static void draw(const Params&, D& draws, int unit, Fixed& fixed, State& state) {
    const auto index = static_cast<std::uint32_t>(unit);
    state.spots[unit] = static_cast<std::uint32_t>((std::uint64_t{draws.word(1, index)} * kSpots) >> 32);
    fixed.drifts[unit] = draws.word(2, index) >> 31;
  }
  template <class D>
  static double move(const Params&, const Fixed& fixed, const State& state, int, const Evidence& seen,
                     D& draws, int unit, State& next) {
    const auto index = static_cast<std::uint32_t>(unit);
    const std::uint32_t far = fixed.drifts[unit] != 0 ? 10 + (draws.word(3, index) >> 28) : 0;
    next.spots[unit] = std::min<std::uint32_t>(state.spots[unit] + far, kSpots - 1);
    return chance(static_cast<int>(next.spots[unit]), seen.readings[unit]);
  }
  static void copy(int unit, const Fixed& fixed, const State& state, Fixed& to_fixed, State& to_state) {
    to_state.spots[unit] = state.spots[unit];
    to_fixed.drifts[unit] = fixed.drifts[unit];
  }
  static int values(int unit, const Fixed& fixed, const State& state, double* out) {
    out[0] = state.spots[unit];
    out[1] = fixed.drifts[unit];
    return 2;
  }
};

// A reading of a thing at `spot`, one of those with positive chance.
int reading_of(int spot, PhiloxDraws& draws, std::uint32_t index) {
  const auto part = [&](std::uint32_t i) { return static_cast<int>(draws.word(9, 2 * index + i) >> 7) % 50; };
  return spot + part(0) - part(1);
}

TEST(ParticleFilter, IsAsWideAsThePosteriorOfWhatStandsStill) {
  using U = Standing<1>;
  constexpr int kRuns = 300, kSteps = 40;
  const U::Params params;
  ParticleFilter<U> filter(params, 400);
  double squares = 0.0, width = 0.0, exact_width = 0.0, off = 0.0;
  for (std::uint32_t run = 0; run < kRuns; ++run) {
    PhiloxDraws draws(derive(5, StreamKind::kTest, run), 0, 0);
    const int spot = 100 + static_cast<int>(draws.word(8, 0) % 800);
    std::vector<double> posterior(kSpots, 1.0);
    filter.init(derive(6, StreamKind::kBelief, run), {}, {});
    for (std::uint32_t step = 0; step < kSteps; ++step) {
      const int reading = reading_of(spot, draws, step);
      for (int i = 0; i < kSpots; ++i) posterior[static_cast<std::size_t>(i)] *= 50.0 * chance(i, reading);
      if (!filter.weigh({}, 0, {reading}, 16)) ++off;
      filter.accept();
    }
    double total = 0.0, mean = 0.0, square = 0.0, filter_mean = 0.0, filter_square = 0.0;
    for (int i = 0; i < kSpots; ++i) {
      const double p = posterior[static_cast<std::size_t>(i)];
      total += p;
      mean += p * i;
      square += p * i * i;
    }
    mean /= total;
    const double deviation = std::sqrt(std::max(0.0, square / total - mean * mean));
    for (int i = 0; i < filter.count(0); ++i) {
      U::Fixed fixed{};
      U::State state{};
      filter.put(0, i, fixed, state);
      filter_mean += filter.weight(0, i) * state.spots[0];
      filter_square += filter.weight(0, i) * state.spots[0] * state.spots[0];
    }
    squares += std::pow((filter_mean - mean) / deviation, 2.0);
    width += std::sqrt(std::max(0.0, filter_square - filter_mean * filter_mean));
    exact_width += deviation;
  }
  EXPECT_EQ(off, 0.0);
  EXPECT_LT(std::sqrt(squares / kRuns),
            0.2);  // of the posterior's deviation; without moves some runs are lost
  EXPECT_NEAR(width / exact_width, 1.0, 0.03);
}

// All that a filter of nine things believes after some steps.
std::vector<double> believed(int threads) {
  using U = Standing<9>;
  const U::Params params;
  ParticleFilter<U> filter(params, 1000);
  Threads workers(threads);
  if (threads > 1) filter.use(&workers);
  filter.init(derive(6, StreamKind::kBelief, 0), {}, {});
  PhiloxDraws draws(derive(5, StreamKind::kTest, 0), 0, 0);
  for (std::uint32_t step = 0; step < 12; ++step) {
    std::vector<int> readings;
    for (std::uint32_t i = 0; i < 9; ++i)
      readings.push_back(reading_of(100 + 90 * static_cast<int>(i), draws, step * 9 + i));
    filter.weigh({}, 0, readings, 16);
    filter.accept();
  }
  std::vector<double> all;
  for (int unit = 0; unit < 9; ++unit) {
    for (int i = 0; i < filter.count(unit); ++i) {
      U::Fixed fixed{};
      U::State state{};
      filter.put(unit, i, fixed, state);
      all.insert(all.end(), {filter.weight(unit, i), 1.0 * state.spots[unit], 1.0 * fixed.drifts[unit]});
    }
  }
  return all;
}

TEST(ParticleFilter, IsTheSameForEveryNumberOfThreads) {
  const std::vector<double> alone = believed(1);
  EXPECT_EQ(alone.size(), 3U * 9 * 125);  // a sure unit has an eighth of the particles
  EXPECT_EQ(believed(2), alone);
  EXPECT_EQ(believed(5), alone);
}

TEST(ParticleFilter, GoesOnWithoutWhatNoParticleExplains) {
  using U = Standing<1>;
  const U::Params params;
  ParticleFilter<U> filter(params, 400);
  filter.init(derive(6, StreamKind::kBelief, 0), {}, {});
  ASSERT_TRUE(filter.weigh({}, 0, {500}, 16));
  filter.accept();
  EXPECT_FALSE(filter.weigh({}, 0, {-100}, 0));
  filter.accept();
  ASSERT_TRUE(filter.weigh({}, 0, {500}, 16));
  filter.accept();
  EXPECT_GT(filter.effective_size(0), 199.0);
}

TEST(ParticleFilter, StartsAgainWhereWhatWasSeenExplainsNothing) {
  using U = Standing<2>;
  const U::Params params;
  ParticleFilter<U> filter(params, 400);
  filter.init(derive(6, StreamKind::kBelief, 0), {}, {});
  for (int step = 0; step < 5; ++step) {
    ASSERT_TRUE(filter.weigh({}, 0, {500, 300}, 16));
    filter.accept();
  }
  EXPECT_FALSE(filter.weigh({}, 0, {100, 310}, 16));
  EXPECT_FALSE(filter.weigh({}, 0, {100, 310}, 0));
  EXPECT_EQ(filter.restart({}), 1);
  filter.accept();
  for (int step = 0; step < 20; ++step) {
    ASSERT_TRUE(filter.weigh({}, 0, {100, 310}, 16));
    filter.accept();
  }
  double means[2] = {};
  for (int unit = 0; unit < 2; ++unit) {
    for (int i = 0; i < filter.count(unit); ++i) {
      U::Fixed fixed{};
      U::State state{};
      filter.put(unit, i, fixed, state);
      means[unit] += filter.weight(unit, i) * state.spots[unit];
    }
  }
  EXPECT_NEAR(means[0], 100.0, 3.0);
  EXPECT_NEAR(means[1], 308.0, 4.0);
  EXPECT_GT(filter.health()[0].distinct, 10U);  // it moves as before
}

TEST(PathLikelihood, ComparesProductsBeyondTheRangeOfDoubles) {
  PathLikelihood low, high;
  for (int i = 0; i < 1000; ++i) {
    low.multiply(1e-9);
    high.multiply(i == 0 ? 2e-9 : 1e-9);
  }
  EXPECT_TRUE(high.exceeds(1.9, low));
  EXPECT_FALSE(high.exceeds(2.1, low));
  high.multiply(0.0);
  EXPECT_FALSE(high.exceeds(0.0, low));
  EXPECT_TRUE(low.exceeds(1.0, high));
}

}  // namespace
}  // namespace hypgen::testing
