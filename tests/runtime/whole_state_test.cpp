// SPDX-License-Identifier: Apache-2.0
#include "hypgen/belief/whole_state.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "hypgen/belief/particle_belief.hpp"
#include "hypgen/belief/posterior.hpp"
#include "test_workers.hpp"

namespace hypgen::testing {
namespace {

constexpr int kSpots = 1000, kShift = 40;

double chance(int spot, int reading) { return std::max(0.0, 1.0 - std::abs(spot - reading) / 50.0) / 50.0; }

// A thing stands at one of kSpots spots. It is seen blurred, and shifted while a switch is on that changes now
// and then. A number that nothing reads is drawn in every step, so whole states are never equal.
struct Shifted : NoHistory, NotFactored {
  static constexpr int kActionCount = 1, kVisibleCount = 0, kVariableCount = 3;
  using Key = std::uint64_t;
  struct Params {};
  struct Fixed {
    std::uint32_t words[1];  // the spot
  };
  struct State {
    std::uint32_t words[2];  // the switch, the number
  };

  static void import_visible(const std::int32_t*, Fixed& fixed, State& state) {
    fixed = {};
    state = {};
  }
  static void export_visible(const Fixed&, const State&, std::int32_t*) {}
  static void export_state(const Fixed& fixed, const State& state, std::int32_t* out) {
    out[0] = static_cast<std::int32_t>(fixed.words[0]);
    out[1] = static_cast<std::int32_t>(state.words[0]);
    out[2] = static_cast<std::int32_t>(state.words[1]);
  }
  template <class D>
  static void init_hidden(const Params&, D& draws, Fixed& fixed, State& state) {
    fixed.words[0] = static_cast<std::uint32_t>((std::uint64_t{draws.word(1, 0)} * kSpots) >> 32);
    state.words[0] = draws.word(2, 0) >> 31;
    state.words[1] = draws.word(3, 0);
  }
  template <class D>
  static StepResult step(const Params&, const Fixed&, const State& state, int, D& draws, State& next) {
    next.words[0] = state.words[0] ^ (draws.word(4, 0) >> 30 == 0 ? 1 : 0);
    next.words[1] = draws.word(5, 0);
    return {};
  }
  template <class D>
  static double filter(const Params& params, const Fixed& fixed, const State& state, int action,
                       const Key& reading, D& draws, State& next) {
    step(params, fixed, state, action, draws, next);
    return chance(static_cast<int>(fixed.words[0] + kShift * next.words[0]), static_cast<int>(reading));
  }
  static bool is_legal(const Params&, const Fixed&, const State&, int) { return true; }
  template <class D>
  static int default_policy(const Params&, const Fixed&, const State&, const History&, D&) {
    return 0;
  }
};

// A reading of the thing at `spot`, one of those with positive chance.
int reading_of(int spot, bool shifted, PhiloxDraws& draws, std::uint32_t index) {
  const auto part = [&](std::uint32_t i) { return static_cast<int>(draws.word(9, 2 * index + i) >> 7) % 50; };
  return spot + (shifted ? kShift : 0) + part(0) - part(1);
}

struct Moments {
  double mean, deviation;
};

template <class Weight>
Moments moments(int values, const Weight& weight) {
  double total = 0.0, sum = 0.0, squares = 0.0;
  for (int i = 0; i < values; ++i) {
    total += weight(i);
    sum += weight(i) * i;
    squares += weight(i) * i * i;
  }
  return {sum / total, std::sqrt(std::max(0.0, squares / total - sum / total * sum / total))};
}

TEST(WholeState, IsAsWideAsThePosteriorOfWhatStandsStill) {
  constexpr std::uint32_t kRuns = 150, kSteps = 40;
  const Shifted::Params params;
  ParticleBelief<Shifted> belief(params, 6, 400);
  double squares = 0.0, width = 0.0, exact_width = 0.0;
  for (std::uint32_t run = 0; run < kRuns; ++run) {
    PhiloxDraws draws(derive(5, StreamKind::kTest, run), 0, 0);
    const int spot = 100 + static_cast<int>(draws.word(8, 0) % 800);
    bool shifted = draws.word(8, 1) >> 31 != 0;
    std::vector<double> off(kSpots, 0.5), on(kSpots, 0.5);
    belief.init(nullptr, run);
    for (std::uint32_t step = 0; step < kSteps; ++step) {
      shifted = shifted != (draws.word(10, step) >> 30 == 0);
      const int reading = reading_of(spot, shifted, draws, step);
      for (std::size_t i = 0; i < kSpots; ++i) {
        const double stays_off = 0.75 * off[i] + 0.25 * on[i], stays_on = 0.25 * off[i] + 0.75 * on[i];
        off[i] = 50.0 * stays_off * chance(static_cast<int>(i), reading);
        on[i] = 50.0 * stays_on * chance(static_cast<int>(i) + kShift, reading);
      }
      if (belief.update(0, words_of(static_cast<std::uint64_t>(reading))) != Status::kOk)
        belief.propagate(0, words_of(static_cast<std::uint64_t>(reading)));
    }
    const Moments exact = moments(
        kSpots, [&](int i) { return off[static_cast<std::size_t>(i)] + on[static_cast<std::size_t>(i)]; });
    std::vector<double> held(kSpots, 0.0);
    ScenarioBuffer buffer;
    belief.reserve(buffer, belief.size());
    std::vector<double> weights;
    belief.export_particles(buffer, weights);
    std::vector<Shifted::Fixed> fixed(belief.size());
    std::vector<Shifted::State> states(belief.size());
    buffer.copy_to(fixed.data(), states.data());
    for (std::size_t i = 0; i < belief.size(); ++i) held[fixed[i].words[0]] += weights[i];
    const Moments found = moments(kSpots, [&](int i) { return held[static_cast<std::size_t>(i)]; });
    squares += std::pow((found.mean - exact.mean) / exact.deviation, 2.0);
    width += found.deviation;
    exact_width += exact.deviation;
  }
  EXPECT_LT(std::sqrt(squares / kRuns), 0.3);  // of the posterior's deviation
  EXPECT_NEAR(width / exact_width, 1.0, 0.08);
}

// All particles and weights after some steps.
std::vector<double> believed(int threads) {
  const Shifted::Params params;
  ParticleBelief<Shifted> belief(params, 6, 1000);
  Threads workers(threads);
  if (threads > 1) belief.use(&workers);
  belief.init(nullptr, 0);
  PhiloxDraws draws(derive(5, StreamKind::kTest, 0), 0, 0);
  for (std::uint32_t step = 0; step < 12; ++step)
    belief.update(0, words_of(static_cast<std::uint64_t>(reading_of(500, step % 4 == 0, draws, step))));
  ScenarioBuffer buffer;
  belief.reserve(buffer, belief.size());
  std::vector<double> all;
  belief.export_particles(buffer, all);
  std::vector<Shifted::Fixed> fixed(belief.size());
  std::vector<Shifted::State> states(belief.size());
  buffer.copy_to(fixed.data(), states.data());
  for (std::size_t i = 0; i < belief.size(); ++i)
    all.insert(all.end(), {1.0 * fixed[i].words[0], 1.0 * states[i].words[0], 1.0 * states[i].words[1]});
  return all;
}

TEST(WholeState, IsTheSameForEveryNumberOfThreads) {
  const std::vector<double> alone = believed(1);
  EXPECT_EQ(believed(2), alone);
  EXPECT_EQ(believed(5), alone);
}

TEST(WholeState, CountsTheValuesThatAreLeftOfWhatHadMany) {
  const Shifted::Params params;
  ParticleBelief<Shifted> belief(params, 6, 400);
  belief.init(nullptr, 0);
  const std::size_t first = belief.health()[0].distinct;
  EXPECT_GT(first, 250U);  // of the spot: each particle has another number
  EXPECT_LT(first, 400U);
  for (int step = 0; step < 10; ++step) ASSERT_EQ(belief.update(0, words_of(500)), Status::kOk);
  const UnitHealth health = belief.health()[0];
  EXPECT_EQ(health.particles, 400U);
  EXPECT_LT(health.distinct, 100U);
  EXPECT_GT(health.distinct, 20U);
}

}  // namespace
}  // namespace hypgen::testing
