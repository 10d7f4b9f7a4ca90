// SPDX-License-Identifier: Apache-2.0
// A thread's counts in a search. Other threads may read them while it goes on.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>

#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/search/decision.hpp"

namespace hypgen {

// A number that one thread writes and all may read, at any time. Relaxed, so that it costs no more than a
// plain number. It is copied only while its thread is parked.
class Counter {
 public:
  Counter() = default;
  Counter(const Counter& other) : value_(other.get()) {}
  Counter& operator=(const Counter& other) {
    set(other.get());
    return *this;
  }

  std::uint64_t get() const { return value_.load(std::memory_order_relaxed); }
  void set(std::uint64_t value) { value_.store(value, std::memory_order_relaxed); }
  void add(std::uint64_t more) { set(get() + more); }
  void add(std::chrono::nanoseconds time) { add(static_cast<std::uint64_t>(time.count())); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

struct SearchCounts {
  Counter trials, expansions, children, collisions, leaf_scenarios, simulations, max_depth;
  Counter waiting, descent, backup;  // in ns

  void add_expansion(const LeafResult& leaf, int depth) {
    expansions.add(1);
    leaf_scenarios.add(leaf.count);
    children.add(leaf.children.size());
    simulations.add(std::uint64_t{leaf.count} * leaf.actions.size());
    max_depth.set(std::max(max_depth.get(), static_cast<std::uint64_t>(depth)));
  }

  void add_to(Decision& decision) const {
    decision.trials += trials.get();
    decision.expansions += expansions.get();
    decision.children += children.get();
    decision.collisions += collisions.get();
    decision.leaf_scenarios += leaf_scenarios.get();
    decision.simulations += simulations.get();
    decision.max_depth = std::max(decision.max_depth, static_cast<int>(max_depth.get()));
    decision.waiting_seconds += 1e-9 * static_cast<double>(waiting.get());
    decision.descent_seconds += 1e-9 * static_cast<double>(descent.get());
    decision.backup_seconds += 1e-9 * static_cast<double>(backup.get());
  }
};

}  // namespace hypgen
