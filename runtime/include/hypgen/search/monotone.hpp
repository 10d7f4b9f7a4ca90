// Numbers that several threads move without a lock. Each move is one successful compare-exchange, and who
// made it knows by how much: that difference is its to pass on. All accesses are sequentially consistent.
#pragma once

#include <algorithm>
#include <atomic>

namespace hypgen {

inline void add(std::atomic<double>& sum, double change) {
  double before = sum.load();
  while (!sum.compare_exchange_weak(before, before + change)) {
  }
}

// Raises a lower bound to `value` at least; gives by how much. Whoever does has to look at the upper bound
// next (`lower_to`): the two may cross.
inline double raise_to(std::atomic<double>& lower_bound, double value) {
  double before = lower_bound.load();
  while (before < value) {
    if (lower_bound.compare_exchange_weak(before, value)) return value - before;
  }
  return 0.0;
}

// Lowers an upper bound to `value` at most, but not below the lower bound, and lifts it if that has passed
// it; gives by how much. It looks at the lower bound again after its own move, as `raise_to` does at the
// upper one: of two threads one sees what the other has done.
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
