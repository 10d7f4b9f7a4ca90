// SPDX-License-Identifier: Apache-2.0
// The shares of scenarios in the groups of an action, where groups share scenarios.
//
// A few observations are drawn, and each makes a group. A scenario's share in a group is how likely the group's
// observation is for it, beside those of the other groups. Garg, Hsu and Lee, "DESPOT-alpha" (RSS 2019), and Wu et
// al., "Adaptive Online Packing-guided Search for POMDPs" (NeurIPS 2021), weigh scenarios by their observations so.
// docs/decisions/0071-scenarios-with-weights.md says what differs.
#pragma once

#include <cstddef>
#include <cstdint>

#include "hypgen/core/config.hpp"
#include "hypgen/leaves/weighted_sums.hpp"
#include "hypgen/model/model.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

// The site of the draw by which a group takes its members.
constexpr std::uint32_t kMembersSite = site_id("leaves:draw_members");

// Where the shares of some scenarios lie: arrays of the caller. Those by group have kMostShared entries for each
// scenario.
template <class State>
struct SharesMemory {
  State* nexts;               // by group and class; unused unless the key holds state
  double* posteriors;         // by group and class: of one scenario of the class
  std::uint32_t* shares;      // the same
  std::uint64_t* sums;        // by scenario that has not ended: the shares in a group up to it
  std::uint32_t* key_of;      // by scenario: the group of those that see the same, or kShared
  std::uint32_t* key_firsts;  // by such a group
  std::uint32_t* live;        // the scenarios that have not ended
  std::uint32_t* class_of;    // by scenario
  std::uint32_t* first_of;    // by class
  std::uint32_t* size_of;     // by class
};

// How many members a group of `mass` has: as many as its mass has scenarios, but not fewer than a few.
HYPGEN_FN std::uint32_t members_for(std::uint32_t mass, std::uint32_t parent_count, std::uint32_t most) {
  constexpr std::uint32_t kFewMembers = 16;
  const std::uint32_t least = kFewMembers < most ? kFewMembers : most;
  const std::uint32_t own = (mass + kScenarioMass / 2) / kScenarioMass;
  const std::uint32_t limit = least < parent_count ? parent_count : least;
  return own < least ? least : own > limit ? limit : own;
}

// One thread that does all the work of a method. The threads of a warp share it in `cuda::Warp`.
struct Alone {
  static constexpr std::uint32_t size = 1;

  HYPGEN_FN std::uint32_t rank() const { return 0; }
  HYPGEN_FN void wait() const {}
  template <class T>
  HYPGEN_FN T sum(T value) const {
    return value;
  }
  // Of the threads up to this one.
  template <class T>
  HYPGEN_FN T sum_up_to(T value) const {
    return value;
  }
  HYPGEN_FN double largest(double value) const { return value; }
};

// The same on every target, bit for bit: sums are of integers, so that their order does not matter.
//
// Its calls come in this order: `begin`, `enter` for each scenario, all weights, `add` for each drawn observation,
// `share_out`, and `group_the_rest`. Those that take a team are called by each of its threads.
template <class M>
class ScenarioShares {
 public:
  using State = typename M::State;

  static constexpr std::uint32_t kMostShared = 16;  // groups that share scenarios

  HYPGEN_FN void begin(const SharesMemory<State>& memory, std::uint32_t count) {
    memory_ = memory;
    count_ = count;
    live_count_ = classes_ = shared_ = rest_ = 0;
  }

  // Takes a scenario that has not ended. Scenarios of a class have the same shares: `alike(i, j)` says whether all
  // observations are as likely for both.
  template <class Alike>
  HYPGEN_FN void enter(std::uint32_t i, const Alike& alike) {
    std::uint32_t known = 0;
    while (known < classes_ && !alike(memory_.first_of[known], i)) ++known;
    if (known == classes_) {
      memory_.first_of[classes_] = i;
      memory_.size_of[classes_++] = 0;
    }
    memory_.live[live_count_++] = i;
    memory_.class_of[i] = known;
    ++memory_.size_of[known];
  }

  // The same for a scenario that stands for itself, as the n-th that has not ended.
  HYPGEN_FN void enter_alone(std::uint32_t i, std::uint32_t n) {
    memory_.first_of[n] = memory_.live[n] = i;
    memory_.size_of[n] = 1;
    memory_.class_of[i] = n;
  }
  // How many such there were.
  HYPGEN_FN void end_entering(std::uint32_t live) { live_count_ = classes_ = live; }

  // How many observations are drawn, and the scenarios that see them: spread out, as neighbours often stem from one
  // scenario.
  HYPGEN_FN std::uint32_t draws() const {
    const std::uint32_t most = count_ / kScenariosAGroup;
    const std::uint32_t wanted = most < kFewGroups ? kFewGroups : most > kMostShared ? kMostShared : most;
    return wanted < live_count_ ? wanted : live_count_;
  }
  HYPGEN_FN std::uint32_t drawn(std::uint32_t n) const {
    return memory_.live[(2 * n + 1) * live_count_ / (2 * draws())];
  }

  HYPGEN_FN std::uint32_t live_count() const { return live_count_; }
  HYPGEN_FN std::uint32_t classes() const { return classes_; }
  HYPGEN_FN std::uint32_t shared() const { return shared_; }
  HYPGEN_FN std::uint32_t scenario_of(std::uint32_t c) const { return memory_.first_of[c]; }
  // How likely the n-th drawn observation is for a class, and the state in which it is seen. No number counts as 0.
  HYPGEN_FN double& weight(std::uint32_t n, std::uint32_t c) { return memory_.posteriors[n * count_ + c]; }
  HYPGEN_FN State& next_seen(std::uint32_t n, std::uint32_t c) { return memory_.nexts[n * count_ + c]; }

  // Adds the group of the n-th drawn observation, which scenario `from` sees, or another draw to the group whose belief
  // is about the same. Groups take the places of weights that were added before.
  template <class Team>
  HYPGEN_FN void add(const Team& team, std::uint32_t n, std::uint32_t from) {
    double* const weights = memory_.posteriors + n * count_;
    const std::uint32_t groups = shared_;
    double most = 0.0;
    for (std::uint32_t c = team.rank(); c < classes_; c += team.size) {
      if (weights[c] > most) most = weights[c];
    }
    most = team.largest(most);
    if (!(most > 0.0) || !(most <= kLargest)) return;
    std::uint64_t total = 0;
    for (std::uint32_t c = team.rank(); c < classes_; c += team.size) {
      const double part = weights[c] > 0.0 ? weights[c] / most * kWeightUnits : 0.0;
      const auto units = static_cast<std::uint64_t>(part);  // a weight below a unit is none
      weights[c] = static_cast<double>(units);
      total += units * memory_.size_of[c];
    }
    total = team.sum(total);
    for (std::uint32_t c = team.rank(); c < classes_; c += team.size)
      weights[c] /= static_cast<double>(total);
    std::uint32_t known = 0;
    while (known < groups && distance(team, known, weights) > kPacked) ++known;
    if (known == groups && n != groups) {
      for (std::uint32_t c = team.rank(); c < classes_; c += team.size) {
        memory_.posteriors[groups * count_ + c] = weights[c];
        if constexpr (kKeyHoldsState<M>) next_seen(groups, c) = next_seen(n, c);
      }
    }
    team.wait();
    if (team.rank() == 0) {
      if (known < groups) {
        ++draws_[known];
      } else {
        draws_[groups] = 1;
        firsts_[groups] = from;
        shared_ = groups + 1;
      }
    }
    team.wait();
  }

  // A group's observation was drawn with the density that all scenarios have of it together. So a class's share is its
  // posterior in the group, times how often that was drawn.
  template <class Team>
  HYPGEN_FN void share_out(const Team& team) {
    for (std::uint32_t c = team.rank(); c < classes_; c += team.size) share_out_class(c);
    team.wait();
  }

  // Scenarios that no drawn observation explains stand with those that see the same: `number(i)` numbers what they see
  // by first appearance.
  template <class Team, class Number>
  HYPGEN_FN void group_the_rest(const Team& team, const Number& number) {
    std::uint32_t unexplained = 0;
    for (std::uint32_t n = team.rank(); n < live_count_; n += team.size) {
      const std::uint32_t i = memory_.live[n];
      const bool explained = is_explained(memory_.class_of[i]);
      memory_.key_of[i] = explained ? kShared : kUnexplained;
      if (!explained) ++unexplained;
    }
    if (team.sum(unexplained) > 0 && team.rank() == 0) {
      for (std::uint32_t n = 0; n < live_count_; ++n) {
        const std::uint32_t i = memory_.live[n];
        if (memory_.key_of[i] != kUnexplained) continue;
        memory_.key_of[i] = number(i);
        if (memory_.key_of[i] == rest_) memory_.key_firsts[rest_++] = i;
      }
    }
    team.wait();
  }

  // The groups: those that share scenarios, and then the rest.
  HYPGEN_FN std::uint32_t count() const { return shared_ + rest_; }
  // The groups of the rest so far, and the scenario that one of them has first.
  HYPGEN_FN std::uint32_t rest() const { return rest_; }
  HYPGEN_FN std::uint32_t first_of_rest(std::uint32_t n) const { return memory_.key_firsts[n]; }
  // The scenario whose observation makes a group. It names the group.
  HYPGEN_FN std::uint32_t first(std::uint32_t group) const {
    return group < shared_ ? firsts_[group] : memory_.key_firsts[group - shared_];
  }
  // The group of that name; `count()` if there is none.
  HYPGEN_FN std::uint32_t named(std::uint32_t scenario) const {
    std::uint32_t group = 0;
    while (group < count() && first(group) != scenario) ++group;
    return group;
  }
  // The share of a scenario that has not ended. Its shares add up to kWholeShare.
  HYPGEN_FN std::uint32_t share(std::uint32_t group, std::size_t scenario) const {
    if (group >= shared_) return memory_.key_of[scenario] == group - shared_ ? kWholeShare : 0;
    return memory_.shares[group * count_ + memory_.class_of[scenario]];
  }
  // The first of the groups with the scenario's largest share.
  HYPGEN_FN std::uint32_t likeliest(std::size_t scenario) const {
    if (memory_.key_of[scenario] != kShared) return shared_ + memory_.key_of[scenario];
    std::uint32_t best = 0;
    for (std::uint32_t g = 1; g < shared_; ++g) {
      if (share(g, scenario) > share(best, scenario)) best = g;
    }
    return best;
  }
  // The state in which a scenario sees what the group sees; null: its own.
  HYPGEN_FN const State* next(std::uint32_t group, std::size_t scenario) const {
    if (!kKeyHoldsState<M> || group >= shared_) return nullptr;
    return &memory_.nexts[group * count_ + memory_.class_of[scenario]];
  }

  // Calls `take(i, scenario)` for each i < `wanted`: systematic sampling of a group's scenarios by their shares.
  template <class Team, class Take>
  HYPGEN_FN void draw(const Team& team, std::uint32_t group, std::size_t wanted, std::uint32_t word,
                      const Take& take) const {
    std::uint64_t total = 0;
    for (std::uint32_t first = 0; first < live_count_; first += team.size) {
      const std::uint32_t n = first + team.rank();
      const std::uint64_t own = n < live_count_ ? share(group, memory_.live[n]) : 0;
      const std::uint64_t reached = total + team.sum_up_to(own);  // all threads meet here
      if (n < live_count_) memory_.sums[n] = reached;
      total += team.sum(own);
    }
    team.wait();
    for (std::size_t i = team.rank(); i < wanted; i += team.size) {
      const WideSum pointer = static_cast<WideSum>((std::uint64_t{i} << 32) + word) * total;
      std::uint32_t first = 0, last = live_count_ - 1;  // the pointer is in one of these
      while (first < last) {
        const std::uint32_t middle = (first + last) / 2;
        if ((static_cast<WideSum>(memory_.sums[middle]) * wanted << 32) <= pointer) {
          first = middle + 1;
        } else {
          last = middle;
        }
      }
      take(i, memory_.live[first]);
    }
  }

 private:
  static constexpr std::uint32_t kShared = UINT32_MAX;
  static constexpr std::uint32_t kUnexplained = UINT32_MAX - 1;
  static constexpr double kPacked = 0.1;  // groups whose beliefs are as near, in L1, are one
  static constexpr double kLargest = 1.7976931348623157e308;
  static constexpr double kWeightUnits = 1 << 30;
  static constexpr double kDistanceUnits = std::uint64_t{1} << 52;
  static constexpr std::uint32_t kScenariosAGroup = 8;
  static constexpr std::uint32_t kFewGroups = 4;

  // Between the belief of a group and another, in L1.
  template <class Team>
  HYPGEN_FN double distance(const Team& team, std::uint32_t group, const double* other) const {
    std::uint64_t sum = 0;
    for (std::uint32_t c = team.rank(); c < classes_; c += team.size) {
      const double apart = other[c] - memory_.posteriors[group * count_ + c];
      sum += static_cast<std::uint64_t>((apart < 0.0 ? -apart : apart) * kDistanceUnits) * memory_.size_of[c];
    }
    return static_cast<double>(team.sum(sum)) / kDistanceUnits;
  }

  HYPGEN_FN void share_out_class(std::uint32_t c) {
    double sum = 0.0;
    for (std::uint32_t g = 0; g < shared_; ++g) sum += draws_[g] * memory_.posteriors[g * count_ + c];
    std::uint32_t left = sum > 0.0 ? kWholeShare : 0;
    std::uint32_t largest = 0;
    for (std::uint32_t g = 0; g < shared_; ++g) {
      const double part = left > 0 ? draws_[g] * memory_.posteriors[g * count_ + c] / sum : 0.0;
      const auto wanted = static_cast<std::uint32_t>(kWholeShare * part);
      const std::uint32_t share = wanted < left ? wanted : left;
      memory_.shares[g * count_ + c] = share;
      left -= share;
      if (share > memory_.shares[largest * count_ + c]) largest = g;
    }
    if (left > 0) memory_.shares[largest * count_ + c] += left;
  }

  HYPGEN_FN bool is_explained(std::uint32_t c) const {
    for (std::uint32_t g = 0; g < shared_; ++g) {
      if (memory_.shares[g * count_ + c] > 0) return true;
    }
    return false;
  }

  // Without first values, as a block of a device may share it. `begin` sets them.
  SharesMemory<State> memory_;
  std::uint32_t count_;  // of scenarios
  std::uint32_t live_count_;
  std::uint32_t classes_;
  std::uint32_t shared_;  // groups that share scenarios
  std::uint32_t rest_;    // groups of those that no drawn observation explains
  std::uint32_t firsts_[kMostShared];
  std::uint32_t draws_[kMostShared];  // observations that each stands for
};

}  // namespace hypgen
