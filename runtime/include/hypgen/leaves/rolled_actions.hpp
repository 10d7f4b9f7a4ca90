// SPDX-License-Identifier: Apache-2.0
// The choice of the actions of a leaf that are rolled out: the same on every target, bit for bit.
//
// A rollout of the default policy costs far more than a step, and a trial goes on below one to three actions
// of a node. So a leaf steps all actions and bounds them from above, and rolls out only those that a trial is
// likely to take. The lower bound of any other action is the floor of its successors; a maximum over fewer
// lower bounds is still a lower bound.
#pragma once

#include <cstdint>

#include "hypgen/core/config.hpp"

namespace hypgen {

constexpr std::uint32_t kRollsAll = UINT32_MAX;  // in place of a number of actions

// What an action promises a leaf: rewards and discounted upper bounds, summed over its scenarios. The unit is
// that of the sums.
HYPGEN_FN double promise(std::int64_t reward_sum, std::int64_t upper_sum, double discount) {
  return static_cast<double>(reward_sum) + discount * static_cast<double>(upper_sum);
}

// Whether rolling an action out can raise the leaf's lower bound.
HYPGEN_FN bool can_raise(double promised, std::int64_t leaf_lower_sum) {
  return promised > static_cast<double>(leaf_lower_sum);
}

}  // namespace hypgen
