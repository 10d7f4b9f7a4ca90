// SPDX-License-Identifier: Apache-2.0
// A small decision process with every outcome, and what its states are worth.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace hypgen::relaxation {

// The choices and outcomes of all states, one after the other. Terminal outcomes are left out: they are worth
// nothing.
struct Outcomes {
  std::vector<std::int64_t> first_choice = {0};   // of each state, and one more: where the last one's end
  std::vector<std::int64_t> first_outcome = {0};  // of each choice, likewise
  std::vector<double> reward;                     // expected, of each choice
  std::vector<std::int32_t> next;                 // of each outcome
  std::vector<double> probability;

  // Leaves no states; keeps the memory.
  void clear() {
    first_choice.assign(1, 0);
    first_outcome.assign(1, 0);
    reward.clear();
    next.clear();
    probability.clear();
  }
};

// Outcomes looked at in all sweeps together: about a second.
constexpr double kMostWork = 1e9;
constexpr double kNegligible = 1e-9;  // of a value

// Value iteration in place.
class Iteration {
 public:
  Iteration(const Outcomes& outcomes, double discount, bool may_stop)
      : outcomes_(outcomes),
        discount_(discount),
        may_stop_(may_stop),
        values_(outcomes.first_choice.size() - 1, 0.0) {}

  // Sweeps forth and back, so that what a state is worth runs along both ways in a single sweep.
  void run() {
    const auto size = static_cast<double>(outcomes_.next.size() + outcomes_.reward.size() + values_.size());
    for (double work = size; work <= kMostWork; work += 2 * size) {
      double change = 0.0;
      double largest = 0.0;
      for (std::size_t i = 0; i < values_.size(); ++i) update(i, change, largest);
      for (std::size_t i = values_.size(); i-- > 0;) update(i, change, largest);
      if (change <= kNegligible * largest) return;
    }
  }

  // The optimal values V* lie at most d / (1 - discount) above the present ones V, d the most that one more
  // sweep would raise a value by; so V* = T V* lies at most discount d / (1 - discount) above T V.
  std::vector<double> above() const { return beyond(1.0); }

  // Likewise from below, with the most that a sweep would lower a value by.
  std::vector<double> below() const { return beyond(-1.0); }

 private:
  // One more sweep, and what others may add to it in the direction of `sign`.
  std::vector<double> beyond(double sign) const {
    std::vector<double> result(values_.size());
    double moved = 0.0;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      result[i] = backup(i);
      moved = std::max(moved, sign * (result[i] - values_[i]));
    }
    for (double& value : result) value += sign * discount_ * moved / (1.0 - discount_);
    return result;
  }

  double backup(std::size_t state) const {
    const auto begin = static_cast<std::size_t>(outcomes_.first_choice[state]);
    const auto end = static_cast<std::size_t>(outcomes_.first_choice[state + 1]);
    if (begin == end) return 0.0;  // no legal action: the episode ends
    double best = -std::numeric_limits<double>::infinity();
    auto outcome = static_cast<std::size_t>(outcomes_.first_outcome[begin]);
    for (std::size_t choice = begin; choice < end; ++choice) {
      double after = 0.0;
      const auto last = static_cast<std::size_t>(outcomes_.first_outcome[choice + 1]);
      for (; outcome < last; ++outcome) {
        after += outcomes_.probability[outcome] * values_[static_cast<std::size_t>(outcomes_.next[outcome])];
      }
      best = std::max(best, outcomes_.reward[choice] + discount_ * after);
    }
    return may_stop_ ? std::max(best, 0.0) : best;
  }

  void update(std::size_t state, double& change, double& largest) {
    const double value = backup(state);
    change = std::max(change, std::abs(value - values_[state]));
    largest = std::max(largest, std::abs(value));
    values_[state] = value;
  }

  const Outcomes& outcomes_;
  double discount_;
  bool may_stop_;
  std::vector<double> values_;
};

// What knowing the state is worth from each state: never too little, and too much by rounding alone where the
// iteration comes to its end. `may_stop`: an episode may end after any step.
inline std::vector<double> worth(const Outcomes& outcomes, double discount, bool may_stop) {
  Iteration iteration(outcomes, discount, may_stop);
  iteration.run();
  return iteration.above();
}

// What is earned where each state has one choice, never too much.
inline std::vector<double> earned(const Outcomes& outcomes, double discount) {
  Iteration iteration(outcomes, discount, false);
  iteration.run();
  return iteration.below();
}

}  // namespace hypgen::relaxation
