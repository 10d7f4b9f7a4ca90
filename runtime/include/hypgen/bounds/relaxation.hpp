// SPDX-License-Identifier: Apache-2.0
// Bounds from small models: fills a table with what a group of rewards can be worth from each state, and one
// with what the default policy earns.
//
// A generated model calls `relaxation::fill` for its groups when params are loaded, and `fill_earned` where
// one group has all rewards and the policy is a function of its states. A group's states are numbered; its
// step is the model's own, of the variables that the group needs, over every outcome of the draws.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <thread>
#include <vector>

#include "hypgen/bounds/small_process.hpp"
#include "hypgen/core/span.hpp"
#include "hypgen/model/model.hpp"
#include "hypgen/random/enumerating_draws.hpp"

namespace hypgen::relaxation {

// A float so far above `value` that the float sum of one such entry of each of `groups` tables is no less
// than the sum of the values: with u = 2^-24, a sum of n floats e_i in any order is off by at most
// ((1 + u)^(n - 1) - 1) sum |e_i| <= n u sum |e_i| for n <= 2^12. An entry of a value v >= 0 is at most
// (1 + m)(1 + 4u) v for a margin m <= 1/2, so n u |e_i| <= 2 n u |v_i|, and m >= 2 n u makes up for it; of
// v < 0, |e_i| <= |v_i|; of v = 0 it is the least float, which is more than n u times itself.
inline float rounded_up(double value, std::size_t groups) {
  const double margin = std::max(1e-6, static_cast<double>(groups) * 0x1p-23);
  return std::nextafter(static_cast<float>(value + margin * std::abs(value)),
                        std::numeric_limits<float>::infinity());
}

// A float below `value`.
inline float rounded_down(double value) { return -rounded_up(-value, 1); }

// More outcomes than this take seconds, and 12 bytes each.
constexpr std::size_t kMostOutcomes = std::size_t{1} << 26;
// The most of the squares of the choices' outcomes: to come to an outcome of a long list takes as many
// comparisons as there are before it.
constexpr double kMostComparisons = 4e9;

// A group of one model's rewards.
template <class Params, class Fixed, class State>
struct Group {
  std::int32_t states;
  Span<const int> actions;  // that differ for the group
  void (*put)(std::int32_t index, Fixed&, State&);
  std::int32_t (*index)(const Fixed&, const State&);
  bool (*is_legal)(const Params&, const Fixed&, const State&, int action);
  StepResult (*step)(const Params&, const Fixed&, const State&, int action, exact::EnumeratingDraws&, State&);
  float (*declared)(const Params&, const Fixed&, const State&);  // a bound on the whole; null: none
  float* table;
  std::int32_t rows = 1;         // of the table: state i is in row i % rows
  int reward_bits = kFixedBits;  // of the model's rewards

  float& entry(std::int32_t i) const { return table[i % rows * (states / rows) + i / rows]; }
};

// The default policy: -1 where no action is legal.
template <class Params, class Fixed, class State>
using Policy = int (*)(const Params&, const Fixed&, const State&, exact::EnumeratingDraws&);

// Goes through a group's states.
template <class Params, class Fixed, class State>
class Enumeration {
 public:
  Enumeration(const Group<Params, Fixed, State>& group, const Params& params)
      : group_(group),
        params_(params),
        unit_(math::power_of_two(-group.reward_bits)),
        place_(static_cast<std::size_t>(group.states), 0) {}

  // Gives all outcomes; false if there are too many, or a reward is NaN.
  bool run(Outcomes& outcomes) {
    for (std::int32_t i = 0; i < group_.states; ++i) {
      Fixed fixed;
      State state;
      group_.put(i, fixed, state);
      for (const int action : group_.actions) {
        if (!group_.is_legal(params_, fixed, state, action)) continue;
        if (!add(fixed, state, [&] { return action; }, outcomes)) return false;
      }
      if (!end_state(outcomes)) return false;
    }
    return true;
  }

  // The same of what a policy does, which draws along with the step.
  bool run(Policy<Params, Fixed, State> policy, Outcomes& outcomes) {
    for (std::int32_t i = 0; i < group_.states; ++i) {
      Fixed fixed;
      State state;
      group_.put(i, fixed, state);
      const auto choose = [&] { return policy(params_, fixed, state, draws_); };
      if (!add(fixed, state, choose, outcomes) || !end_state(outcomes)) return false;
    }
    return true;
  }

 private:
  // Ends the list of a state's choices; false if there are too many outcomes.
  static bool end_state(Outcomes& outcomes) {
    outcomes.first_choice.push_back(static_cast<std::int64_t>(outcomes.reward.size()));
    return outcomes.next.size() <= kMostOutcomes;
  }

  // Appends what a choice leads to; false if there are too many paths to try, or a reward is NaN. No action
  // (-1) ends the episode.
  template <class Choose>
  bool add(const Fixed& fixed, const State& state, const Choose& choose, Outcomes& outcomes) {
    const auto first = static_cast<std::size_t>(outcomes.first_outcome.back());
    double reward = 0.0;
    double paths = 0.0;
    draws_.start();
    do {
      State next;
      const int action = choose();
      StepResult result{};
      result.terminal = true;
      if (action >= 0) result = group_.step(params_, fixed, state, action, draws_, next);
      const double probability = draws_.probability();
      if (result.is_broken()) return false;
      reward += probability * unit_ * static_cast<double>(result.reward);
      paths += 1.0;
      if (comparisons_ + paths * paths > kMostComparisons) return false;
      if (!result.terminal) lead_to(group_.index(fixed, next), probability, first, outcomes);
    } while (draws_.next());
    comparisons_ += paths * paths;
    outcomes.reward.push_back(reward);
    outcomes.first_outcome.push_back(static_cast<std::int64_t>(outcomes.next.size()));
    return true;
  }

  void lead_to(std::int32_t next, double probability, std::size_t first, Outcomes& outcomes) {
    std::size_t& place = place_[static_cast<std::size_t>(next)];
    if (place < first || place >= outcomes.next.size() || outcomes.next[place] != next) {
      place = outcomes.next.size();
      outcomes.next.push_back(next);
      outcomes.probability.push_back(0.0);
    }
    outcomes.probability[place] += probability;
  }

  const Group<Params, Fixed, State>& group_;
  const Params& params_;
  double unit_;                     // what 1 stands for in a reward
  std::vector<std::size_t> place_;  // of each state among the outcomes, where it was met last
  exact::EnumeratingDraws draws_;
  double comparisons_ = 0.0;
};

// Fills the table of one of `groups` groups: infinity where it cannot be enumerated, or the declared bound
// where there is one that is less (or NaN, which the search then reports).
template <class Params, class Fixed, class State>
void fill_one(const Group<Params, Fixed, State>& group, std::size_t groups, const Params& params,
              double discount, bool may_stop, Outcomes& outcomes) {
  std::vector<double> values;
  outcomes.clear();
  if (Enumeration<Params, Fixed, State>(group, params).run(outcomes)) {
    values = worth(outcomes, discount, may_stop);
  }
  for (std::int32_t i = 0; i < group.states; ++i) {
    float& entry = group.entry(i);
    entry = values.empty() ? std::numeric_limits<float>::infinity()
                           : rounded_up(values[static_cast<std::size_t>(i)], groups);
    if (group.declared == nullptr) continue;
    Fixed fixed;
    State state;
    group.put(i, fixed, state);
    const float declared = group.declared(params, fixed, state);
    if (!(entry < declared)) entry = declared;
  }
}

// Fills a table with what the policy earns for ever from each state, where the group has all rewards; with
// `tail` where that cannot be enumerated.
template <class Params, class Fixed, class State>
void fill_earned(const Group<Params, Fixed, State>& group, Policy<Params, Fixed, State> policy,
                 float (*tail)(const Params&, const Fixed&, const State&), float* table, const Params& params,
                 double discount) {
  Outcomes outcomes;
  std::vector<double> values;
  if (Enumeration<Params, Fixed, State>(group, params).run(policy, outcomes)) {
    values = earned(outcomes, discount);
  }
  for (std::int32_t i = 0; i < group.states; ++i) {
    if (!values.empty()) {
      table[i] = rounded_down(values[static_cast<std::size_t>(i)]);
      continue;
    }
    Fixed fixed;
    State state;
    group.put(i, fixed, state);
    table[i] = tail(params, fixed, state);
  }
}

// Threads that fill tables: what they enumerate takes up to some hundred MiB each.
constexpr std::size_t kMostThreads = 8;

// Fills the tables of all groups, side by side where there are several cores.
template <class Params, class Fixed, class State, std::size_t count>
void fill(const Group<Params, Fixed, State> (&groups)[count], const Params& params, double discount,
          bool may_stop) {
  std::atomic<std::size_t> taken{0};
  const auto work = [&] {
    Outcomes outcomes;
    for (std::size_t i = taken++; i < count; i = taken++) {
      fill_one(groups[i], count, params, discount, may_stop, outcomes);
    }
  };
  std::vector<std::thread> threads;
  const std::size_t cores = std::thread::hardware_concurrency();
  for (std::size_t i = 1; i < std::min({count, cores, kMostThreads}); ++i) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
}

}  // namespace hypgen::relaxation
