// SPDX-License-Identifier: Apache-2.0
// Systematic sampling: one random word places all pointers.
#pragma once

#include <cstddef>
#include <cstdint>

namespace hypgen {

// Calls `take(i, pick)` for each i < count: `pick` is one of `values` numbers with weights that add up to 1.
template <class Weight, class Take>
void choose(const Weight& weight, int values, std::uint32_t word, std::size_t count, const Take& take) {
  const double stride = 1.0 / static_cast<double>(count);
  const double offset = static_cast<double>(word) * 0x1p-32;
  int end = values;
  while (end > 1 && !(weight(end - 1) > 0.0)) --end;  // the sum of weights may round to below 1
  int pick = 0;
  double reached = weight(0);
  for (std::size_t i = 0; i < count; ++i) {
    const double pointer = (static_cast<double>(i) + offset) * stride;
    while (reached <= pointer && pick + 1 < end) reached += weight(++pick);
    take(i, pick);
  }
}

}  // namespace hypgen
