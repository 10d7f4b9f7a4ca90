// SPDX-License-Identifier: Apache-2.0
// The share of a step that one warp of a block takes.
#pragma once

#include "hypgen/core/config.hpp"

namespace hypgen {

constexpr int kMostWarps = 16;  // that share steps

// Warp `rank` of `count` warps. The updates of a stage are numbered, and warp i % count does number i.
struct Part {
  int rank;
  int count;

  HYPGEN_FN bool takes(int number) const { return number % count == rank; }

  // How far behind `number` the first one is that this warp takes.
  HYPGEN_FN int first(int number) const {
    const int behind = (rank - number) % count;
    return behind < 0 ? behind + count : behind;
  }
};

}  // namespace hypgen
