// SPDX-License-Identifier: Apache-2.0
// Weights of scenarios in integers, whose sums have the same bits in every order.
#pragma once

#include <cstdint>

namespace hypgen {

// A scenario's shares in the groups of an action add up to this.
constexpr int kShareBits = 16;
constexpr std::uint32_t kWholeShare = 1U << kShareBits;

// What a scenario of the root counts for in the rows of a search that weighs.
constexpr std::uint32_t kScenarioMass = 1U << 16;

__extension__ using WideSum = __int128;

// The mean of `sum` over `whole`, for a node of that mass: a sum over scenarios of the root, rounded down.
constexpr std::int64_t spread(WideSum sum, std::uint64_t mass, std::uint64_t whole) {
  const WideSum product = sum * static_cast<WideSum>(mass);
  const WideSum divisor = static_cast<WideSum>(whole) * kScenarioMass;
  const WideSum quotient = product / divisor;
  return static_cast<std::int64_t>(product % divisor < 0 ? quotient - 1 : quotient);
}

}  // namespace hypgen
