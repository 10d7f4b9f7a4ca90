// SPDX-License-Identifier: Apache-2.0
// Numbers that several threads move without a lock. Each move is one successful compare-exchange. The thread
// that made the move knows the difference and passes it on. All accesses are sequentially consistent.
#pragma once

#include <algorithm>
#include <atomic>

namespace hypgen {

inline void add(std::atomic<double>& sum, double change) {
  double before = sum.load();
  while (!sum.compare_exchange_weak(before, before + change)) {
  }
}

// Raises a lower bound to `value` or leaves it; gives the difference. The caller looks at the upper bound
// next (`lower_to`), because the two may have crossed.
inline double raise_to(std::atomic<double>& lower_bound, double value) {
  double before = lower_bound.load();
  while (before < value) {
    if (lower_bound.compare_exchange_weak(before, value)) return value - before;
  }
  return 0.0;
}

// Lowers an upper bound to `value`, but not below the lower bound, or raises it to a lower bound that has
// passed it; gives the difference. It looks at the lower bound again after its own move. So of two threads,
// one that moves the upper bound and one that moves the lower, at least one sees the other's move.
inline double lower_to(std::atomic<double>& upper_bound, const std::atomic<double>& lower_bound,
                       double value) {
  double change = 0.0;
  double before = upper_bound.load();
  while (true) {
    const double after = std::max(lower_bound.load(), std::min(before, value));
    if (after == before) return change;
    if (!upper_bound.compare_exchange_weak(before, after)) continue;
    change += after - before;
    before = after;
  }
}

}  // namespace hypgen
