// SPDX-License-Identifier: Apache-2.0
// Parts the members of a node after an action, where groups share scenarios, and draws the members of a group.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <vector>

#include "hypgen/leaves/cpu_scene.hpp"
#include "hypgen/leaves/weighted_groups.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

// Its calls take the `Work` that simulates the model: its `params`, the `fixed` part of a member's state, the `draws` of
// a number at a depth, and a `clock`. The draws of a member are those of its place in the node.
template <class M>
class WeightedParts {
 public:
  using State = typename M::State;

  // `most`: members of a node.
  explicit WeightedParts(std::size_t most) : groups_(most), nexts_(most) {}

  // Forgets the previous search, so that results do not depend on it.
  void begin_search() { depends_on_draws_ = false; }

  std::size_t most() const { return nexts_.size(); }
  const WeightedGroups<M>& groups() const { return groups_; }
  // A member's state after the action.
  const State& next(std::size_t i) const { return nexts_[i]; }

  // Steps members, and gives each result to `note(i, result)`; false if time is over.
  template <class Work, class Note>
  bool step(Work& work, int action, const CpuMember<M>* members, std::size_t count, int depth,
            const Note& note) {
    for (std::size_t i = 0; i < count; ++i) {
      if (work.clock.add(1)) return false;
      auto words = work.draws(static_cast<std::uint32_t>(i), depth);
      note(i, M::step(work.params, work.fixed(members[i]), members[i].state, action, words, nexts_[i]));
    }
    return true;
  }

  // Parts members that were stepped into groups; false if time is over. `has_ended(i)`: the episode has.
  template <class Work, class HasEnded>
  bool part(Work& work, int action, const CpuMember<M>* members, std::size_t count, int depth,
            const HasEnded& has_ended) {
    const bool depended = depends_on_draws_;
    if (!part_once(work, action, members, count, depth, has_ended)) return false;
    return depended == depends_on_draws_ || part_once(work, action, members, count, depth, has_ended);
  }

  // Draws the members of a group of parted ones, which `mass` and its number in the groups name, to `drawn`; gives how
  // many. `key`: of the search.
  std::size_t draw(std::uint32_t group, std::uint32_t mass, StreamKey key, int action, int depth,
                   const CpuMember<M>* members, std::size_t count, CpuMember<M>* drawn) {
    const std::uint32_t wanted =
        members_for(mass, static_cast<std::uint32_t>(count), static_cast<std::uint32_t>(nexts_.size()));
    const std::uint32_t word = PhiloxDraws(key, groups_.first(group), static_cast<std::uint32_t>(depth))
                                   .word(kMembersSite, static_cast<std::uint32_t>(action));
    groups_.draw(Alone{}, group, wanted, word, [&](std::size_t i, std::size_t pick) {
      const State* const next = groups_.next(group, pick);
      drawn[i] = {members[pick].scenario, next != nullptr ? *next : nexts_[pick]};
    });
    return wanted;
  }

  // What member i sees after the action.
  template <class Work>
  typename M::Key seen(Work& work, int action, const CpuMember<M>* members, std::size_t i, int depth) {
    auto words = work.draws(static_cast<std::uint32_t>(i), depth);
    return M::observe(work.params, work.fixed(members[i]), members[i].state, action, words, nexts_[i]);
  }

  template <class T>
  static bool is_same(const T& a, const T& b) {
    return std::is_empty_v<T> || std::memcmp(&a, &b, sizeof a) == 0;
  }

 private:
  template <class Work, class HasEnded>
  bool part_once(Work& work, int action, const CpuMember<M>* members, std::size_t count, int depth,
                 const HasEnded& has_ended) {
    const auto observe = [&](std::size_t i) { return seen(work, action, members, i, depth); };
    const auto weigh = [&](std::size_t i, const typename M::Key& key, [[maybe_unused]] State& next) {
      auto words = work.draws(static_cast<std::uint32_t>(i), depth);
      WatchedDraws watched(words);
      const typename M::Fixed& fixed = work.fixed(members[i]);
      double density = 0.0;
      if constexpr (kKeyHoldsState<M>) {
        density = M::filter(work.params, fixed, members[i].state, action, key, watched, next);
      } else {
        density =
            M::observation_density(work.params, fixed, members[i].state, action, key, watched, nexts_[i]);
      }
      depends_on_draws_ |= watched.is_read();
      return density;
    };
    // Members to which all observations are as likely: those of the same states, unless draws of the step count too.
    const auto alike = [&](std::size_t i, std::size_t j) {
      return !depends_on_draws_ && is_same(nexts_[i], nexts_[j]) &&
             is_same(members[i].state, members[j].state) &&
             is_same(work.fixed(members[i]), work.fixed(members[j]));
    };
    return groups_.make(count, has_ended, alike, observe, weigh,
                        [&](std::size_t steps) { return work.clock.add(steps); });
  }

  WeightedGroups<M> groups_;
  std::vector<State> nexts_;       // after the action in work, by member
  bool depends_on_draws_ = false;  // how likely observations are, besides states
};

}  // namespace hypgen
