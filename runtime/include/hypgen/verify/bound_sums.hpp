// SPDX-License-Identifier: Apache-2.0
// The results of comparing a model's bounds with returns.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace hypgen {

// The bounds that are compared; `declared`: the upper bound of the model's text where a derived one is in
// use.
enum class Bound : std::size_t { kUpper, kDeclared, kLower, kTail };
constexpr std::size_t kBounds = 4;

// What came of comparing one bound.
struct BoundSums {
  std::uint64_t compared = 0;    // beliefs
  std::uint64_t violations = 0;  // of them
  double room = 0.0;             // sum, over beliefs, of how far the bound lies on the right side of the mean

  void add(const BoundSums& other) {
    compared += other.compared;
    violations += other.violations;
    room += other.room;
  }
};
using BoundsFound = std::array<BoundSums, kBounds>;

}  // namespace hypgen
