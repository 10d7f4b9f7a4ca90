// SPDX-License-Identifier: Apache-2.0
// An interval that holds the value of the best policy of a small model.
//
// Heuristic search value iteration (HSVI2, Smith & Simmons, UAI 2005) between alpha vectors and the sawtooth
// bound, both kept for each class of states (mixed observability: Ong et al., IJRR 2010). Every iterate is
// sound, so the search may be stopped at any moment. Arithmetic is in doubles: both ends are moved outwards
// by `IntervalResult::slack`, a bound of what all rounding together can have changed.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "hypgen/exact/exact_model.hpp"
#include "hypgen/exact/first_actions.hpp"
#include "hypgen/exact/policy.hpp"

namespace hypgen::exact {

struct IntervalOptions {
  double seconds = 60.0;
  double gap = 1e-3;  // upper - lower at which to stop, relative to `IntervalResult::size`
  std::size_t bytes = std::size_t{2} << 30;  // of beliefs, vectors and points together
};

// kRounding: what is left of the gap is so little that no trial changes a bound.
enum class IntervalEnd { kConverged, kTime, kMemory, kRounding, kStopped };

struct IntervalResult {
  double lower = 0.0;
  double upper = 0.0;
  double least_size = 1.0;  // 1, or what a step can be worth at the most if that is less
  // At the start, weighted over starts: upper bounds ...
  double mdp = 0.0;
  double qmdp = 0.0;
  double fib = 0.0;
  // ... and a lower bound, of the best blind policy.
  double blind = 0.0;
  bool acts_at_random = false;   // ... or of acting at random: every fixed action may go on for ever
  std::uint64_t iterations = 0;  // trials
  std::size_t beliefs = 0;
  std::size_t points = 0;
  std::size_t vectors = 0;
  double slack = 0.0;  // no end has been moved by more
  double seconds = 0.0;
  IntervalEnd end = IntervalEnd::kTime;

  // What differences are small or large against.
  double size() const { return std::max({least_size, std::abs(lower), std::abs(upper)}); }
  bool converged() const { return end == IntervalEnd::kConverged; }
};

// Is told what has been proven so far, a few times a second, and returns false to stop.
using IntervalProgress = std::function<bool(const IntervalResult&)>;

// What the solver leaves: the interval, and policies that act on the exact belief.
struct IntervalSolution {
  IntervalResult result;
  AlphaPolicy alpha;  // worth at least `result.lower`
  AlphaPolicy qmdp;
  AlphaPolicy blind;                 // worth `result.blind`
  std::vector<FirstDecision> first;  // after the likeliest starts, up to `kMostFirst`
};

// Throws std::invalid_argument, which says why, where neither a discount below 1 nor a horizon bounds values
// and a policy that never ends may cost nothing.
IntervalSolution solve_interval(const ExactModel& model, const IntervalOptions& options,
                                const IntervalProgress& progress);

}  // namespace hypgen::exact
