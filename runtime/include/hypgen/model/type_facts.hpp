// SPDX-License-Identifier: Apache-2.0
// The part of a model's description that follows from its type.
#pragma once

#include "hypgen/model/descriptor.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen {

// A descriptor with the counts filled in.
template <class M>
ModelDescriptor describe() {
  ModelDescriptor descriptor;
  descriptor.action_count = M::kActionCount;
  descriptor.visible_count = M::kVisibleCount;
  descriptor.variable_count = M::kVariableCount;
  descriptor.reward_bits = kRewardBits<M>;
  descriptor.factored = M::kFactored;
  descriptor.rolls_out = !M::kHasLower;
  return descriptor;
}

}  // namespace hypgen
