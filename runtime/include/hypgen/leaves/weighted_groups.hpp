// SPDX-License-Identifier: Apache-2.0
// The groups of scenarios after an action on the host, where groups share scenarios.
#pragma once

#include <cstdint>
#include <vector>

#include "hypgen/leaves/grouping.hpp"
#include "hypgen/leaves/scenario_shares.hpp"
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
class WeightedGroups : public ScenarioShares<M> {
 public:
  using State = typename M::State;
  using Key = typename M::Key;
  using ScenarioShares<M>::kMostShared;

  // The memory of one scenario.
  static constexpr std::size_t kScenarioBytes =
      kMostShared * ((kKeyHoldsState<M> ? sizeof(State) : 0) + sizeof(double) + sizeof(std::uint32_t)) +
      sizeof(std::uint64_t) + 6 * sizeof(std::uint32_t) + 4 * (sizeof(Key) + 2 * sizeof(std::uint32_t));

  // `most`: scenarios.
  explicit WeightedGroups(std::size_t most)
      : nexts_(kKeyHoldsState<M> ? most * kMostShared : 0),
        posteriors_(most * kMostShared),
        shares_(most * kMostShared),
        sums_(most),
        numbers_(kNumbers * most),
        keys_(most) {}

  // Makes the groups of `count` scenarios. Scenarios of a class have the same shares: `alike(i, j)` says whether all
  // observations are as likely for both. `observe(i)` gives what scenario i sees. `weigh(i, key, next)` gives how
  // likely another's observation is for it. Where the key holds state it also sets the state in which it sees that.
  // False if `is_over(steps)` held after so many calls of `weigh`.
  template <class IsTerminal, class Alike, class Observe, class Weigh, class IsOver>
  bool make(std::size_t count, const IsTerminal& is_terminal, const Alike& alike, const Observe& observe,
            const Weigh& weigh, const IsOver& is_over) {
    const std::size_t most = sums_.size();
    std::uint32_t* const numbers = numbers_.data();
    this->begin({nexts_.data(), posteriors_.data(), shares_.data(), sums_.data(), numbers, numbers + most,
                 numbers + 2 * most, numbers + 3 * most, numbers + 4 * most, numbers + 5 * most},
                static_cast<std::uint32_t>(count));
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!is_terminal(i)) this->enter(i, alike);
    }
    // Scenarios of one class have one group, whatever they see.
    const std::uint32_t draws = this->classes() == 1 ? 1 : this->draws();
    State unused;
    for (std::uint32_t n = 0; n < draws; ++n) {
      const std::uint32_t from = this->drawn(n);
      const Key key = observe(from);
      for (std::uint32_t c = 0; c < this->classes(); ++c) {
        this->weight(n, c) =
            weigh(this->scenario_of(c), key, kKeyHoldsState<M> ? this->next_seen(n, c) : unused);
      }
      this->add(Alone{}, n, from);
      if (is_over(this->classes())) return false;
    }
    this->share_out(Alone{});
    keys_.clear();
    this->group_the_rest(Alone{}, [&](std::uint32_t i) { return keys_.number(observe(i)); });
    return true;
  }

 private:
  static constexpr std::size_t kNumbers = 6;  // a scenario

  std::vector<State> nexts_;
  std::vector<double> posteriors_;
  std::vector<std::uint32_t> shares_;
  std::vector<std::uint64_t> sums_;
  std::vector<std::uint32_t> numbers_;
  Grouping<Key> keys_;
};

}  // namespace hypgen
