// SPDX-License-Identifier: Apache-2.0
#include "hypgen/belief/value_moves.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "hypgen/belief/particle_filter.hpp"
#include "test_workers.hpp"

namespace hypgen::testing {
namespace {

constexpr std::uint32_t kSpots = 40;

// Two things at different spots. A step tells how many of them lie left of a spot: nothing but that, for sure.
struct Pair {
  struct Params {};
  struct State {
    std::uint32_t step;
  };
  struct Fixed {
    struct {
      std::uint32_t spots[2];
    } values;
  };
  struct Key {
    std::uint32_t spot, count;
  };
  struct Evidence {
    Key key;
    State next;
  };
  struct Values {
    using Fixed = decltype(Pair::Fixed::values);
    static constexpr int kHiddenValues = 2;
    static std::int32_t hidden_size(int) { return kSpots; }
    static std::int32_t hidden_value(const Fixed& fixed, int entry) {
      return static_cast<std::int32_t>(fixed.spots[entry]);
    }
    static void put_hidden(Fixed& fixed, int entry, std::int32_t value) {
      fixed.spots[entry] = static_cast<std::uint32_t>(value);
    }
  };
  using Move = ValueMove<Values>;
  static constexpr int kUnits = 1, kValues = 1, kFirstWords = 16;
  static constexpr bool kCountsApart = true, kSeesFirst = false, kRedraws = false, kMovesValues = true;

  static void see(const Params&, const Fixed&, const State&, int, const Key& key, Evidence& seen) {
    seen = {key, {}};
  }
  static const State& visible(const Evidence& seen) { return seen.next; }
  static double weigh_start(const Params&, int, const Fixed&, const State&) { return 1.0; }
  static double start_density(const Params&, const Fixed& fixed, const State&) {
    return fixed.values.spots[0] == fixed.values.spots[1] ? 0.0 : 1.0 / (kSpots * (kSpots - 1));
  }
  template <class D>
  static void draw(const Params&, D& draws, int, Fixed& fixed, State&) {
    const auto below = [&](std::uint32_t site, std::uint32_t count) {
      return static_cast<std::uint32_t>((std::uint64_t{draws.word(site, 0)} * count) >> 32);
    };
    fixed.values.spots[0] = below(1, kSpots);
    fixed.values.spots[1] = (fixed.values.spots[0] + 1 + below(2, kSpots - 1)) % kSpots;
  }
  static double weigh(const Params&, const Fixed& fixed, const State&, int, const Evidence& seen) {
    std::uint32_t count = 0;
    for (const std::uint32_t spot : fixed.values.spots) count += spot < seen.key.spot ? 1 : 0;
    return count == seen.key.count ? 1.0 : 0.0;
  }
  template <class D>
  static double move(const Params& params, const Fixed& fixed, const State& state, int action,
                     const Evidence& seen, D&, int, State& next) {
    next.step = state.step + 1;
    return weigh(params, fixed, state, action, seen);
  }
  static void copy(int, const Fixed& fixed, const State& state, Fixed& to_fixed, State& to_state) {
    to_fixed = fixed;
    to_state = state;
  }
  static int values(int, const Fixed& fixed, const State&, double* out) {
    *out = fixed.values.spots[0] * kSpots + fixed.values.spots[1];
    return 1;
  }
};

// The spots of all particles after steps that leave the first thing in 8 .. 11 and the second in 30 .. 33, or the
// other way round.
std::vector<std::uint32_t> believed(std::size_t particles, int threads) {
  const Pair::Params params;
  ParticleFilter<Pair> filter(params, particles);
  Threads workers(threads);
  if (threads > 1) filter.use(&workers);
  filter.init(derive(6, StreamKind::kBelief, 0), {}, {});
  std::uint32_t step = 0;
  for (const Pair::Key key : {Pair::Key{20, 1}, {8, 0}, {34, 2}, {30, 1}, {12, 1}}) {
    EXPECT_TRUE(filter.weigh({step++}, 0, key, 16));
    filter.accept();
  }
  std::vector<std::uint32_t> all;
  for (int i = 0; i < filter.count(0); ++i) {
    if (!(filter.weight(0, i) > 0.0)) continue;
    all.insert(all.end(), filter.fixed(i).values.spots, filter.fixed(i).values.spots + 2);
  }
  return all;
}

TEST(ValueMoves, FindAllThatExplainsWhatWasSeen) {
  const std::vector<std::uint32_t> spots = believed(4000, 1);
  std::map<std::uint32_t, int> times;
  for (std::size_t i = 0; i < spots.size(); i += 2) ++times[spots[i] * kSpots + spots[i + 1]];
  EXPECT_EQ(times.size(), 32U);
  for (const auto& [place, count] : times)
    EXPECT_NEAR(64.0 * count / static_cast<double>(spots.size()), 1.0, 0.35) << place;
}

// Twelve particles explain all, as moves change them until some do.
TEST(ValueMoves, FindWhatNoParticleHas) {
  const std::vector<std::uint32_t> spots = believed(12, 1);
  for (std::size_t i = 0; i < spots.size(); i += 2) {
    EXPECT_TRUE(std::min(spots[i], spots[i + 1]) / 4 == 2);
    EXPECT_TRUE((std::max(spots[i], spots[i + 1]) - 30) / 4 == 0);
  }
}

TEST(ValueMoves, AreTheSameForEveryNumberOfThreads) {
  const std::vector<std::uint32_t> alone = believed(500, 1);
  EXPECT_EQ(believed(500, 2), alone);
  EXPECT_EQ(believed(500, 5), alone);
}

}  // namespace
}  // namespace hypgen::testing
