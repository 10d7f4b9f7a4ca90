// SPDX-License-Identifier: Apache-2.0
// The groups of scenarios after an action, where groups share scenarios.
//
// A few observations are drawn, and each makes a group. A scenario's share in a group is how likely the group's
// observation is for it, beside those of the other groups. Garg, Hsu and Lee, "DESPOT-alpha" (RSS 2019), and Wu et
// al., "Adaptive Online Packing-guided Search for POMDPs" (NeurIPS 2021), weigh scenarios by their observations so.
// docs/decisions/0071-scenarios-with-weights.md says what differs.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "hypgen/leaves/grouping.hpp"
#include "hypgen/leaves/weighted_sums.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen {

// Draws that tell whether they were read.
template <class Draws>
class WatchedDraws {
 public:
  explicit WatchedDraws(Draws& draws) : draws_(draws) {}

  std::uint32_t word(std::uint32_t site, std::uint32_t index) {
    is_read_ = true;
    return draws_.word(site, index);
  }
  std::uint32_t second_word(std::uint32_t site, std::uint32_t index) {
    is_read_ = true;
    return draws_.second_word(site, index);
  }
  bool is_read() const { return is_read_; }

 private:
  Draws& draws_;
  bool is_read_ = false;
};

template <class Draws>
std::uint32_t second_word(WatchedDraws<Draws>& draws, std::uint32_t site, std::uint32_t index) {
  return draws.second_word(site, index);
}

template <class M>
class WeightedGroups {
 public:
  using State = typename M::State;
  using Key = typename M::Key;

  static constexpr std::size_t kMostShared = 16;  // groups that share scenarios
  // The memory of one scenario.
  static constexpr std::size_t kScenarioBytes =
      kMostShared * ((kKeyHoldsState<M> ? sizeof(State) : 0) + sizeof(double) + sizeof(std::uint32_t)) +
      sizeof(double) + 6 * sizeof(std::uint32_t) + 4 * (sizeof(Key) + 2 * sizeof(std::uint32_t));

  // `most`: scenarios.
  explicit WeightedGroups(std::size_t most)
      : nexts_(kKeyHoldsState<M> ? most * kMostShared : 0),
        posteriors_(most * kMostShared),
        shares_(most * kMostShared),
        posterior_(most),
        keys_(most),
        key_of_(most),
        live_(most),
        class_of_(most),
        first_of_(most),
        size_of_(most) {
    key_firsts_.reserve(most);
  }

  // Makes the groups of `count` scenarios. Scenarios of a class have the same shares: `alike(i, j)` says whether all
  // observations are as likely for both. `observe(i)` gives what scenario i sees. `weigh(i, key, next)` gives how
  // likely another's observation is for it. Where the key holds state it also sets the state in which it sees that.
  // False if `is_over(steps)` held after so many calls of `weigh`.
  template <class IsTerminal, class Alike, class Observe, class Weigh, class IsOver>
  bool make(std::size_t count, const IsTerminal& is_terminal, const Alike& alike, const Observe& observe,
            const Weigh& weigh, const IsOver& is_over) {
    count_ = count;
    live_count_ = 0;
    shared_ = classes_ = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (is_terminal(i)) continue;
      live_[live_count_++] = i;
      classify(i, alike);
    }
    const std::size_t drawn = std::min(live_count_, most_shared());
    for (std::size_t n = 0; n < (classes_ == 1 ? 1 : drawn); ++n) {
      // Spread out, as neighbours often stem from one scenario.
      const std::uint32_t from = live_[(2 * n + 1) * live_count_ / (2 * drawn)];
      add(from, observe(from), weigh);
      if (is_over(classes_)) return false;
    }
    for (std::uint32_t c = 0; c < classes_; ++c) share_out(c);
    group_the_rest(observe);
    return true;
  }

  std::uint32_t count() const { return shared_ + keys_.count(); }
  // The scenario whose observation makes a group. It names the group.
  std::uint32_t first(std::uint32_t group) const {
    return group < shared_ ? firsts_[group] : key_firsts_[group - shared_];
  }
  // The group of that name; `count()` if there is none.
  std::uint32_t named(std::uint32_t scenario) const {
    std::uint32_t group = 0;
    while (group < count() && first(group) != scenario) ++group;
    return group;
  }
  // The share of a scenario that has not ended. Its shares add up to kWholeShare.
  std::uint32_t share(std::uint32_t group, std::size_t scenario) const {
    if (group >= shared_) return key_of_[scenario] == group - shared_ ? kWholeShare : 0;
    return shares_[group * count_ + class_of_[scenario]];
  }
  // The first of the groups with the scenario's largest share.
  std::uint32_t likeliest(std::size_t scenario) const {
    if (key_of_[scenario] != kShared) return shared_ + key_of_[scenario];
    std::uint32_t best = 0;
    for (std::uint32_t g = 1; g < shared_; ++g) {
      if (share(g, scenario) > share(best, scenario)) best = g;
    }
    return best;
  }
  // The state in which a scenario sees what the group sees; null: its own.
  const State* next(std::uint32_t group, std::size_t scenario) const {
    if (!kKeyHoldsState<M> || group >= shared_) return nullptr;
    return &nexts_[group * count_ + first_of_[class_of_[scenario]]];
  }

  // Calls `take(i, scenario)` for each i < `drawn`: systematic sampling of a group's scenarios by their shares.
  template <class Take>
  void draw(std::uint32_t group, std::size_t drawn, std::uint32_t word, const Take& take) const {
    std::uint64_t total = 0;
    for (std::size_t n = 0; n < live_count_; ++n) total += share(group, live_[n]);
    std::size_t at = 0;
    std::uint64_t reached = live_count_ > 0 ? share(group, live_[0]) : 0;
    for (std::size_t i = 0; i < drawn; ++i) {
      const WideSum pointer = static_cast<WideSum>((std::uint64_t{i} << 32) + word) * total;
      while ((static_cast<WideSum>(reached) * drawn << 32) <= pointer) reached += share(group, live_[++at]);
      take(i, live_[at]);
    }
  }

 private:
  static constexpr std::uint32_t kShared = UINT32_MAX;
  static constexpr double kPacked = 0.1;  // groups whose beliefs are as near, in L1, are one
  static constexpr double kWeightUnits = 1 << 30;
  static constexpr double kDistanceUnits = std::uint64_t{1} << 52;
  static constexpr std::size_t kScenariosAGroup = 8;
  static constexpr std::size_t kFewGroups = 4;

  std::size_t most_shared() const { return std::clamp(count_ / kScenariosAGroup, kFewGroups, kMostShared); }

  template <class Alike>
  void classify(std::uint32_t i, const Alike& alike) {
    std::uint32_t known = 0;
    while (known < classes_ && !alike(first_of_[known], i)) ++known;
    if (known == classes_) {
      first_of_[classes_] = i;
      size_of_[classes_++] = 0;
    }
    class_of_[i] = known;
    ++size_of_[known];
  }

  // Adds the group of an observation, or another draw to the group whose belief is about the same.
  template <class Weigh>
  void add(std::uint32_t from, const Key& key, const Weigh& weigh) {
    State unused;
    double most = 0.0;
    for (std::uint32_t c = 0; c < classes_; ++c) {
      const std::uint32_t i = first_of_[c];
      const double weight = weigh(i, key, kKeyHoldsState<M> ? nexts_[shared_ * count_ + i] : unused);
      posterior_[c] = weight > 0.0 ? weight : 0.0;
      most = std::max(most, posterior_[c]);
    }
    if (!(most > 0.0) || !std::isfinite(most)) return;
    // Sums of integers are the same in every order. A weight below a unit is none.
    std::uint64_t total = 0;
    for (std::uint32_t c = 0; c < classes_; ++c) {
      const auto weight = static_cast<std::uint64_t>(posterior_[c] / most * kWeightUnits);
      posterior_[c] = static_cast<double>(weight);
      total += weight * size_of_[c];
    }
    for (std::uint32_t c = 0; c < classes_; ++c) posterior_[c] /= static_cast<double>(total);
    for (std::uint32_t g = 0; g < shared_; ++g) {
      if (distance(g) > kPacked) continue;
      ++draws_[g];
      return;
    }
    std::copy_n(posterior_.begin(), classes_, &posteriors_[shared_ * count_]);
    draws_[shared_] = 1;
    firsts_[shared_++] = from;
  }

  // Between the beliefs of a group and of the one in work, in L1.
  double distance(std::uint32_t group) const {
    std::uint64_t sum = 0;
    for (std::uint32_t c = 0; c < classes_; ++c) {
      const double apart = std::abs(posterior_[c] - posteriors_[group * count_ + c]);
      sum += static_cast<std::uint64_t>(apart * kDistanceUnits) * size_of_[c];
    }
    return static_cast<double>(sum) / kDistanceUnits;
  }

  // A group's observation was drawn with the density that all scenarios have of it together. So a class's share is its
  // posterior in the group, times how often that was drawn.
  void share_out(std::uint32_t c) {
    double sum = 0.0;
    for (std::uint32_t g = 0; g < shared_; ++g) sum += draws_[g] * posteriors_[g * count_ + c];
    std::uint32_t left = sum > 0.0 ? kWholeShare : 0;
    std::uint32_t largest = 0;
    for (std::uint32_t g = 0; g < shared_; ++g) {
      const double part = left > 0 ? draws_[g] * posteriors_[g * count_ + c] / sum : 0.0;
      std::uint32_t& share = shares_[g * count_ + c];
      share = std::min(left, static_cast<std::uint32_t>(kWholeShare * part));
      left -= share;
      if (share > shares_[largest * count_ + c]) largest = g;
    }
    if (left > 0) shares_[largest * count_ + c] += left;
  }

  // Scenarios that no drawn observation explains stand with those that see the same.
  template <class Observe>
  void group_the_rest(const Observe& observe) {
    keys_.clear();
    key_firsts_.clear();
    for (std::size_t n = 0; n < live_count_; ++n) {
      const std::uint32_t i = live_[n];
      key_of_[i] = kShared;
      if (is_explained(class_of_[i])) continue;
      key_of_[i] = keys_.number(observe(i));
      if (key_of_[i] == key_firsts_.size()) key_firsts_.push_back(i);
    }
  }

  bool is_explained(std::uint32_t c) const {
    for (std::uint32_t g = 0; g < shared_; ++g) {
      if (shares_[g * count_ + c] > 0) return true;
    }
    return false;
  }

  std::size_t count_ = 0;  // of scenarios
  std::size_t live_count_ = 0;
  std::uint32_t classes_ = 0;
  std::uint32_t shared_ = 0;  // groups that share scenarios
  std::uint32_t firsts_[kMostShared] = {};
  std::uint32_t draws_[kMostShared] = {};  // observations that each stands for
  std::vector<State> nexts_;               // by group and scenario
  std::vector<double> posteriors_;         // by group and class, of one scenario of the class
  std::vector<std::uint32_t> shares_;      // the same
  std::vector<double> posterior_;          // of the group in work
  Grouping<Key> keys_;
  std::vector<std::uint32_t> key_firsts_;
  std::vector<std::uint32_t> key_of_;  // by scenario; kShared: it stands in groups that share
  std::vector<std::uint32_t> live_;    // scenarios that have not ended
  std::vector<std::uint32_t> class_of_;
  std::vector<std::uint32_t> first_of_;  // by class
  std::vector<std::uint32_t> size_of_;
};

}  // namespace hypgen
