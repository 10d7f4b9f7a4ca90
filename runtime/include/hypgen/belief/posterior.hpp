// SPDX-License-Identifier: Apache-2.0
// The arithmetic of exact posteriors of independent hidden variables. `Real` is double for the agent's
// belief, which takes in many observations, and float for a policy's history.
#pragma once

#include <cstdint>

#include "hypgen/core/config.hpp"

namespace hypgen {

// The base of a model without a factored belief (model/model.hpp).
struct NotFactored {
  struct Posterior {};
  static constexpr bool kFactored = false;
  static constexpr int kExactUnits = 0;

  template <class... Parts>
  HYPGEN_FN static void init_posterior(const Parts&...) {}
  template <class... Parts>
  HYPGEN_FN static bool advance_posterior(const Parts&...) {
    return true;
  }
};

namespace posteriors {

// The probability of one of N joint values. Of two values only the second's probability is stored.
template <int N, class Real>
HYPGEN_FN Real probability(const Real* stored, std::int32_t value) {
  if constexpr (N == 2) return value != 0 ? stored[0] : Real{1} - stored[0];
  return stored[value];
}

// Stores the sums divided by their total. Stores nothing and gives false unless the total is above 0.
template <int N, class Sum, class Real>
HYPGEN_FN bool normalise(const Sum* sums, Real* stored) {
  Sum total{};
  for (int i = 0; i < N; ++i) total += sums[i];
  if (!(total > Sum{})) return false;
  if constexpr (N == 2) {
    stored[0] = static_cast<Real>(sums[1] / total);
  } else {
    for (int i = 0; i < N; ++i) stored[i] = static_cast<Real>(sums[i] / total);
  }
  return true;
}

}  // namespace posteriors
}  // namespace hypgen
