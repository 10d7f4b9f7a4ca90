// SPDX-License-Identifier: Apache-2.0
// One step of a rollout of the default policy: the same on every target.
#pragma once

#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen {

// Takes in a step of a rollout that led to `next`: moves `state` and `history` on and adds what it earned,
// discounted, to `total`. False where the step ended the rollout.
template <class M, class D>
HYPGEN_FN bool take_in(const StepResult& result, const typename M::Params& params,
                       const typename M::Fixed& fixed, int action, D& draws, const typename M::State& next,
                       float discount, typename M::State& state, typename M::History& history, float& total,
                       bool& nan) {
  nan |= is_broken<M>(result);
  total += discount * math::from_fixed<kRewardBits<M>>(result.reward);
  if (result.terminal) return false;
  if constexpr (M::kHasHistory) {
    typename M::History after;
    M::roll_history(params, fixed, state, action, draws, next, history, after);
    history = after;
  }
  state = next;
  return true;
}

// Chooses and takes a step. False where the rollout ends: the step was terminal, or there is no legal action.
template <class M, class D>
HYPGEN_FN bool roll_step(const typename M::Params& params, const typename M::Fixed& fixed, D& draws,
                         float discount, typename M::State& state, typename M::History& history, float& total,
                         bool& nan) {
  const int action = M::default_policy(params, fixed, state, history, draws);
  if (action < 0) return false;
  typename M::State next;
  const StepResult result = M::step(params, fixed, state, action, draws, next);
  return take_in<M>(result, params, fixed, action, draws, next, discount, state, history, total, nan);
}

}  // namespace hypgen
