// SPDX-License-Identifier: Apache-2.0
// Models written by hand as the compiler would write them, and models that go wrong on purpose.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <string>

#include "hypgen/belief/posterior.hpp"
#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/model/descriptor.hpp"
#include "hypgen/model/model.hpp"
#include "hypgen/model/start_values.hpp"

namespace hypgen::testing {

inline bool below(std::uint32_t word, float probability) { return word < math::threshold(probability); }

// Cassandra, Kaelbling and Littman (1994). State and observations: 0 left, 1 right. Listens by default.
struct Tiger : NoHistory, NotFactored {
  static constexpr int kActionCount = 3;  // listen, open_left, open_right
  static constexpr int kVisibleCount = 0;
  static constexpr int kVariableCount = 1;
  using Key = std::uint64_t;
  static constexpr bool kHasLower = false;
  static constexpr std::uint32_t kInitSite = 1, kTigerSite = 2, kHeardSite = 3;

  struct Params {
    float hearing;
  };
  struct Fixed {
    std::uint32_t words[1];
  };
  struct State {
    std::uint32_t words[1];
  };

  template <class D>
  static void init_visible(const Params&, D&, Fixed& fixed, State& state) {
    fixed = {};
    state = {};
  }
  template <class D>
  static void init_hidden(const Params&, D& draws, Fixed&, State& state) {
    state.words[0] = draws.word(kInitSite, 0) >> 31;
  }
  static void export_visible(const Fixed&, const State&, std::int32_t*) {}
  static void import_visible(const std::int32_t*, Fixed& fixed, State& state) {
    fixed = {};
    state = {};
  }
  static void export_state(const Fixed&, const State& state, std::int32_t* out) {
    out[0] = static_cast<std::int32_t>(state.words[0]);
  }
  static bool is_legal(const Params&, const Fixed&, const State&, int) { return true; }
  template <class D>
  static StepResult step(const Params&, const Fixed&, const State& state, int action, D& draws, State& next) {
    next = state;
    if (action == 0) return {math::to_fixed(-1), false, false, false};
    next.words[0] = draws.word(kTigerSite, 0) >> 31;
    const bool opened_tiger = (action == 1) == (state.words[0] == 0);
    return {math::to_fixed(opened_tiger ? -100 : 10), false, false, false};
  }
  template <class D>
  static Key observe(const Params& params, const Fixed&, const State&, int action, D& draws,
                     const State& next) {
    const std::uint32_t word = draws.word(kHeardSite, 0);
    if (action != 0) return word >> 31;
    return below(word, params.hearing) ? next.words[0] : 1 - next.words[0];
  }
  template <class D>
  static double filter(const Params& params, const Fixed& fixed, const State& state, int action, Key key,
                       D& draws, State& next) {
    step(params, fixed, state, action, draws, next);
    return observation_density(params, fixed, state, action, key, draws, next);
  }
  template <class D>
  static double observation_density(const Params& params, const Fixed&, const State&, int action, Key key, D&,
                                    const State& next) {
    if (key > 1) return 0.0;
    if (action != 0) return 0.5;
    return key == next.words[0] ? double{params.hearing} : 1.0 - double{params.hearing};
  }
  template <class D>
  static int default_policy(const Params&, const Fixed&, const State&, const History&, D&) {
    return 0;
  }
  static float lower(const Params&, const Fixed&, const State&, const History&) { return 0.0F; }
  static float upper(const Params&, const Fixed&, const State&) { return 200.0F; }
  static float tail(const Params&, const Fixed&, const State&) { return -20.0F; }
  static bool load(const ParamValues& values, Params& params, std::string& error) {
    return values.copy("hearing", &params.hearing, 1, error);
  }
};

// Smith and Simmons (2004): an n x n grid with k rocks at places made from their number. Goes east by
// default.
template <int N, int K>
struct RockSample : NoHistory, NotFactored {
  static constexpr int kActionCount = 5 + K;  // north, south, east, west, sample, check(rock)
  static constexpr int kVisibleCount = 2;
  static constexpr int kVariableCount = 2 + K;
  using Key = std::uint64_t;
  static constexpr bool kHasLower = false;
  static constexpr std::uint32_t kGoodSite = 11, kReadingSite = 12;
  enum Action { kNorth, kSouth, kEast, kWest, kSample, kCheck };
  enum Reading : std::uint64_t { kNothing, kGood, kBad };

  struct Params {
    int rock_x[K];
    int rock_y[K];
    int rock_at[N][N];                // number, or -1
    std::uint64_t accuracy[N][N][K];  // thresholds
    float accuracy_value[N][N][K];
    float exit_value[N];
  };
  struct Fixed {
    std::uint32_t words[1];
  };
  struct State {
    std::uint32_t words[2];  // position: x | y << 16; bits of good rocks
    int x() const { return static_cast<int>(words[0] & 0xFFFF); }
    int y() const { return static_cast<int>(words[0] >> 16); }
    bool good(int rock) const { return ((words[1] >> rock) & 1) != 0; }
    void place(int x, int y) {
      words[0] = static_cast<std::uint32_t>(x) | static_cast<std::uint32_t>(y) << 16;
    }
  };

  template <class D>
  static void init_visible(const Params&, D& draws, Fixed& fixed, State& state) {
    fixed = {};
    state = {};
    state.place(first_value<int>(draws, 0, 0), first_value<int>(draws, 1, N / 2));
  }
  template <class D>
  static void init_hidden(const Params&, D& draws, Fixed&, State& state) {
    for (int r = 0; r < K; ++r) {
      const std::uint32_t drawn = draws.word(kGoodSite, static_cast<std::uint32_t>(r)) >> 31;
      state.words[1] |= std::uint32_t{first_value<bool>(draws, 2 + r, drawn != 0)} << r;
    }
  }
  static void export_visible(const Fixed&, const State& state, std::int32_t* out) {
    out[0] = state.x();
    out[1] = state.y();
  }
  static void import_visible(const std::int32_t* in, Fixed& fixed, State& state) {
    fixed = {};
    state = {};
    state.place(in[0], in[1]);
  }
  static void export_state(const Fixed& fixed, const State& state, std::int32_t* out) {
    export_visible(fixed, state, out);
    for (int r = 0; r < K; ++r) out[2 + r] = state.good(r);
  }
  static bool is_legal(const Params& params, const Fixed&, const State& state, int action) {
    return action != kSample || params.rock_at[state.x()][state.y()] >= 0;
  }
  template <class D>
  static StepResult step(const Params& params, const Fixed&, const State& state, int action, D&,
                         State& next) {
    next = state;
    const int x = state.x(), y = state.y();
    if (action == kEast && x == N - 1) return {math::to_fixed(10), true, true, false};
    if (action == kNorth) next.place(x, math::min(y + 1, N - 1));
    if (action == kSouth) next.place(x, math::max(y - 1, 0));
    if (action == kEast) next.place(x + 1, y);
    if (action == kWest) next.place(math::max(x - 1, 0), y);
    if (action != kSample) return {0, false, false, false};
    const int rock = params.rock_at[x][y];
    next.words[1] &= ~(1U << rock);
    return {math::to_fixed(state.good(rock) ? 10 : -10), false, false, false};
  }
  template <class D>
  static Key observe(const Params& params, const Fixed&, const State&, int action, D& draws,
                     const State& next) {
    if (action < kCheck) return kNothing;
    const int rock = action - kCheck;
    const bool right = draws.word(kReadingSite, 0) < params.accuracy[next.x()][next.y()][rock];
    return right == next.good(rock) ? kGood : kBad;
  }
  template <class D>
  static double filter(const Params& params, const Fixed& fixed, const State& state, int action, Key key,
                       D& draws, State& next) {
    if (step(params, fixed, state, action, draws, next).terminal) return 0.0;
    return observation_density(params, fixed, state, action, key, draws, next);
  }
  template <class D>
  static double observation_density(const Params& params, const Fixed&, const State&, int action, Key key, D&,
                                    const State& next) {
    if (action < kCheck) return key == kNothing ? 1.0 : 0.0;
    if (key != kGood && key != kBad) return 0.0;
    const int rock = action - kCheck;
    const double accuracy = params.accuracy_value[next.x()][next.y()][rock];
    return (key == kGood) == next.good(rock) ? accuracy : 1.0 - accuracy;
  }
  template <class D>
  static int default_policy(const Params&, const Fixed&, const State&, const History&, D&) {
    return kEast;
  }
  static float lower(const Params&, const Fixed&, const State&, const History&) { return 0.0F; }
  static float upper(const Params& params, const Fixed&, const State& state) {
    float total = params.exit_value[state.x()];
    for (int r = 0; r < K; ++r) total += state.good(r) ? 10.0F : 0.0F;
    return total;
  }
  static float tail(const Params&, const Fixed&, const State&) { return 0.0F; }
  static bool load(const ParamValues&, Params& params, std::string&) {
    for (auto& column : params.rock_at) std::fill(std::begin(column), std::end(column), -1);
    for (int r = 0; r < K; ++r) {
      params.rock_x[r] = (r * 3 + 1) % N;
      params.rock_y[r] = (r * 5 + r / N) % N;
      params.rock_at[params.rock_x[r]][params.rock_y[r]] = r;
    }
    for (int x = 0; x < N; ++x) {
      params.exit_value[x] = 10.0F * std::pow(0.95F, static_cast<float>(N - 1 - x));
      for (int y = 0; y < N; ++y) {
        for (int r = 0; r < K; ++r) {
          const float distance =
              math::hypot(static_cast<float>(x - params.rock_x[r]), static_cast<float>(y - params.rock_y[r]));
          params.accuracy_value[x][y][r] = 0.5F * (1.0F + math::pow(2.0F, -distance / 20.0F));
          params.accuracy[x][y][r] = math::threshold(params.accuracy_value[x][y][r]);
        }
      }
    }
    return true;
  }
};

// A counter that ends at 3, seen exactly; what goes wrong is set by params.
struct Mishaps : NoHistory, NotFactored {
  static constexpr int kActionCount = 2;
  static constexpr int kVisibleCount = 1;
  static constexpr int kVariableCount = 2;
  using Key = std::uint64_t;
  static constexpr bool kHasLower = true;
  static constexpr std::uint32_t kHiddenSite = 21;

  struct Params {
    float upper;
    std::int32_t illegal_from;  // count at which no action is legal any more
  };
  struct Fixed {
    std::uint32_t words[1];
  };
  struct State {
    std::uint32_t words[2];  // visible count; hidden bit, seen in each step
  };

  template <class D>
  static void init_visible(const Params&, D&, Fixed& fixed, State& state) {
    fixed = {};
    state = {};
  }
  template <class D>
  static void init_hidden(const Params&, D& draws, Fixed&, State& state) {
    state.words[1] = draws.word(kHiddenSite, 0) >> 31;
  }
  static void export_visible(const Fixed&, const State& state, std::int32_t* out) {
    out[0] = static_cast<std::int32_t>(state.words[0]);
  }
  static void import_visible(const std::int32_t* in, Fixed& fixed, State& state) {
    fixed = {};
    state = {{static_cast<std::uint32_t>(in[0]), 0}};
  }
  static void export_state(const Fixed& fixed, const State& state, std::int32_t* out) {
    export_visible(fixed, state, out);
    out[1] = static_cast<std::int32_t>(state.words[1]);
  }
  static bool is_legal(const Params& params, const Fixed&, const State& state, int) {
    return static_cast<std::int32_t>(state.words[0]) < params.illegal_from;
  }
  template <class D>
  static StepResult step(const Params&, const Fixed&, const State& state, int action, D&, State& next) {
    next = state;
    ++next.words[0];
    return {math::to_fixed(action), next.words[0] == 3, false, false};
  }
  template <class D>
  static Key observe(const Params&, const Fixed&, const State&, int, D&, const State& next) {
    return next.words[1];
  }
  template <class D>
  static double filter(const Params& params, const Fixed& fixed, const State& state, int action, Key key,
                       D& draws, State& next) {
    if (step(params, fixed, state, action, draws, next).terminal) return 0.0;
    return observation_density(params, fixed, state, action, key, draws, next);
  }
  template <class D>
  static double observation_density(const Params&, const Fixed&, const State&, int, Key key, D&,
                                    const State& next) {
    return key == next.words[1] ? 1.0 : 0.0;
  }
  template <class D>
  static int default_policy(const Params& params, const Fixed& fixed, const State& state, const History&,
                            D&) {
    return is_legal(params, fixed, state, 0) ? 0 : -1;
  }
  static float lower(const Params&, const Fixed&, const State&, const History&) { return 0.0F; }
  static float upper(const Params& params, const Fixed&, const State&) { return params.upper; }
  static float tail(const Params&, const Fixed&, const State&) { return 0.0F; }
  static bool load(const ParamValues& values, Params& params, std::string& error) {
    return values.copy("upper", &params.upper, 1, error) &&
           values.copy("illegal_from", &params.illegal_from, 1, error);
  }
};

}  // namespace hypgen::testing
