// SPDX-License-Identifier: Apache-2.0
// The best way to share tokens between two agents that act apart.
#pragma once

#include <cstdint>

#include "hypgen/core/config.hpp"

namespace hypgen::relaxation {

// The most that two agents are worth together, by what each is worth with a set of tokens of its own. A bit
// of an index of `first` and `second` stands for a token; `valuable` has those to be shared. All is sums and
// comparisons of floats, so that every machine finds the same.
HYPGEN_FN float best_share(const float* first, const float* second, std::uint32_t valuable) {
  float best = first[0] + second[valuable];
  for (std::uint32_t share = 0; share != valuable;) {
    share = (share - valuable) & valuable;  // the next subset
    const float worth = first[share] + second[valuable ^ share];
    best = worth > best ? worth : best;
  }
  return best;
}

}  // namespace hypgen::relaxation
