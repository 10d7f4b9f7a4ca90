// SPDX-License-Identifier: Apache-2.0
// A model with factors, written by hand as the compiler would write it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "hypgen/belief/posterior.hpp"
#include "hypgen/model/descriptor.hpp"
#include "hypgen/model/history.hpp"
#include "hypgen/model/model.hpp"
#include "test_models.hpp"

namespace hypgen::testing {

// A coin, whose side an exact posterior keeps, and a level from 0 to 9, which rises by 1 or not and which
// particles keep. A reading of both: the coin's with 0.8, the level's exactly or one off. The second
// action ends the episode.
struct CoinAndLevel : NoHistory {
  static constexpr int kActionCount = 2;  // look, end
  static constexpr int kVisibleCount = 0;
  static constexpr int kVariableCount = 2;
  static constexpr bool kHasLower = false;
  static constexpr bool kFactored = true;
  static constexpr int kExactUnits = 1;
  static constexpr int kParticleUnits = 1;
  using Key = std::uint64_t;  // 12 * coin reading + level reading + 1
  static constexpr int kLast = 9;

  struct Params {};
  struct Fixed {
    std::uint32_t words[1];
  };
  struct State {
    std::int32_t words[2];
  };
  struct Posterior {
    double coin[1];
  };

  static double coin_density(int coin, int seen) { return coin == seen ? 0.8 : 0.2; }
  static double level_density(int level, int seen) {
    return level == seen ? 0.5 : std::abs(level - seen) == 1 ? 0.25 : 0.0;
  }

  template <class D>
  static void init_visible(const Params&, D&, Fixed& fixed, State& state) {
    fixed = {};
    state = {};
  }
  template <class D>
  static void init_hidden(const Params&, D& draws, Fixed&, State& state) {
    state.words[0] = below(draws.word(1, 0), 0.5F);
    state.words[1] = static_cast<std::int32_t>((std::uint64_t{draws.word(2, 0)} * 10) >> 32);
  }
  static void export_visible(const Fixed&, const State&, std::int32_t*) {}
  static void import_visible(const std::int32_t*, Fixed& fixed, State& state) {
    fixed = {};
    state = {};
  }
  static void export_state(const Fixed&, const State& state, std::int32_t* out) {
    std::copy_n(state.words, 2, out);
  }
  static bool is_legal(const Params&, const Fixed&, const State&, int) { return true; }
  template <class D>
  static StepResult step(const Params&, const Fixed&, const State& state, int action, D& draws, State& next) {
    next = state;
    rise(draws, next);
    return {0, action == 1, false, false};
  }
  template <class D>
  static void rise(D& draws, State& next) {
    next.words[1] = std::min(next.words[1] + (below(draws.word(3, 0), 0.5F) ? 1 : 0), kLast);
  }
  template <class D>
  static Key observe(const Params&, const Fixed&, const State&, int, D& draws, const State& next) {
    const int off = static_cast<int>(draws.word(5, 0) >> 30);  // 0, 1: none
    const int level = next.words[1] + (off == 2 ? 1 : off == 3 ? -1 : 0);
    const int coin = below(draws.word(4, 0), 0.8F) ? next.words[0] : 1 - next.words[0];
    return static_cast<Key>(coin * 12 + level + 1);
  }
  template <class D>
  static double filter(const Params& params, const Fixed& fixed, const State& state, int action, Key key,
                       D& draws, State& next) {
    step(params, fixed, state, action, draws, next);
    return observation_density(params, fixed, state, action, key, draws, next);
  }
  template <class D>
  static double observation_density(const Params&, const Fixed&, const State&, int, Key key, D&,
                                    const State& next) {
    return coin_density(next.words[0], static_cast<int>(key / 12)) *
           level_density(next.words[1], static_cast<int>(key % 12) - 1);
  }
  template <class D>
  static int default_policy(const Params&, const Fixed&, const State&, const History&, D&) {
    return 0;
  }
  static float upper(const Params&, const Fixed&, const State&) { return 0.0F; }
  static float tail(const Params&, const Fixed&, const State&) { return 0.0F; }
  static float lower(const Params&, const Fixed&, const State&, const History&) { return 0.0F; }
  static bool load(const ParamValues&, Params&, std::string&) { return true; }

  static void init_posterior(const Params&, const Fixed&, const State&, Posterior& after) { after = {{0.5}}; }
  static bool advance_posterior(const Params&, const Fixed&, const State&, int action, Key key, const State&,
                                const Posterior& now, Posterior& after) {
    after = now;
    double sums[2];
    for (int coin = 0; coin < 2; ++coin) {
      const double likelihood = coin_density(coin, static_cast<int>(key / 12));
      sums[coin] = action == 1 ? 0.0 : posteriors::probability<2>(now.coin, coin) * likelihood;
    }
    return posteriors::normalise<2>(sums, after.coin);
  }
  static void advance_visible(const Params&, const Fixed&, const State& state, int, Key, State& next) {
    next = state;
  }
  struct Evidence {
    State next;
    int reading;
  };
  static constexpr int kUnitValues = 1;
  static void see(const Params&, const Fixed&, const State& state, int, Key key, Evidence& seen) {
    seen = {state, static_cast<int>(key % 12) - 1};
  }
  template <class D>
  static void draw_unit(int, const Params&, D& draws, Fixed&, State& state) {
    state.words[1] = static_cast<std::int32_t>((std::uint64_t{draws.word(2, 0)} * 10) >> 32);
  }
  template <class D>
  static double move_unit(int, const Params&, const Fixed&, const State& state, int, const Evidence& seen,
                          D& draws, State& next) {
    next.words[1] = state.words[1];
    rise(draws, next);
    return level_density(next.words[1], seen.reading);
  }
  static int export_unit(int, const Fixed&, const State& state, double* out) {
    out[0] = state.words[1];
    return 1;
  }
  static int unit_size(int) { return 2; }
  static int unit_of(int variable) { return variable == 0 ? 0 : 1; }
  static double probability(const Posterior& posterior, int, std::int32_t value) {
    return posteriors::probability<2>(posterior.coin, value);
  }
  static void put_unit(int, std::int32_t value, Fixed&, State& state) { state.words[0] = value; }
  static void copy_unit(int, const Fixed&, const State& state, Fixed&, State& to_state) {
    to_state.words[1] = state.words[1];
  }
};

// CoinAndLevel whose coin and level have each been seen, as in a step, before the first one.
struct CoinSeenFirst : CoinAndLevel {
  static constexpr int kVisibleCount = 1;

  static void import_visible(const std::int32_t* in, Fixed& fixed, State& state) {
    fixed.words[0] = static_cast<std::uint32_t>(in[0]);  // a key
    state = {};
  }
  static void export_visible(const Fixed& fixed, const State&, std::int32_t* out) {
    out[0] = static_cast<std::int32_t>(fixed.words[0]);
  }
  static double init_likelihood(const Params& params, const Fixed& fixed, const State& state) {
    return coin_density(state.words[0], static_cast<int>(fixed.words[0] / 12)) *
           weigh_start(0, params, fixed, state);
  }
  static bool init_posterior(const Params&, const Fixed& fixed, const State&, Posterior& after) {
    const int seen = static_cast<int>(fixed.words[0] / 12);
    after = {{0.5}};
    const double sums[] = {coin_density(0, seen), coin_density(1, seen)};
    return seen < 2 && posteriors::normalise<2>(sums, after.coin);
  }
  static double weigh_start(int, const Params&, const Fixed& fixed, const State& state) {
    const bool is_key = fixed.words[0] < 24;
    return is_key ? level_density(state.words[1], static_cast<int>(fixed.words[0] % 12) - 1) : 0.0;
  }
};

}  // namespace hypgen::testing
