// SPDX-License-Identifier: Apache-2.0
// Expands leaves whose groups share scenarios, with weights.
//
// A node's members are all as likely, and may repeat a scenario. Each draws under its place in the node, so copies
// part again. After an action, `WeightedGroups` gives each member a share in a few groups. A group becomes a node by
// drawing members by their shares.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <vector>

#include "hypgen/leaves/leaf_work.hpp"
#include "hypgen/leaves/weighted_groups.hpp"
#include "hypgen/leaves/weighted_sums.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

template <class M>
class WeightedLeaves {
 public:
  explicit WeightedLeaves(LeafWork<M>& work)
      : work_(work), groups_(work.scene.options.max_scenarios), nexts_(work.scene.options.max_scenarios) {
    after_.reserve(work.scene.options.max_scenarios);
  }

  // Forgets the previous search, so that results do not depend on it.
  void begin_search() { depends_on_draws_ = false; }

  // Draws the members of a group of an action of `request.parent`; gives their number, or 0 if there is no such group
  // or the deadline has passed.
  std::size_t draw_members(const LeafRequest& request) {
    CpuNode<M>& parent = work_.node(request.parent);
    const CpuMember<M>* const from = parent.members();
    const int depth = request.depth - 1;
    if (!make_groups(request.action, from, parent.count, depth)) return 0;
    const std::uint32_t group = groups_.named(request.first);
    if (group == groups_.count()) return 0;
    const std::uint32_t drawn =
        members_for(request.count, parent.count, static_cast<std::uint32_t>(work_.members.size()));
    const std::uint32_t word =
        PhiloxDraws(work_.cache.key(), request.first, static_cast<std::uint32_t>(depth))
            .word(kMembersSite, static_cast<std::uint32_t>(request.action));
    groups_.draw(Alone{}, group, drawn, word, [&](std::size_t i, std::size_t pick) {
      const State* const next = groups_.next(group, pick);
      work_.members[i] = {from[pick].scenario, next != nullptr ? *next : nexts_[pick]};
    });
    if (M::kHasHistory) see(request.action, from, request.first, depth, parent.history, work_.history);
    return drawn;
  }

  // Makes the rows of the leaf in work. `is_lazy`: not all actions are rolled out, and a first look at them says
  // which are.
  Status evaluate(const LeafRequest& request, std::size_t count, bool is_lazy) {
    for (const int action : work_.legal) {
      if (!step(action, work_.members.data(), count, request.depth)) return Status::kDeadline;
      work_.action_rows.push_back(first_row(action, count, request, is_lazy));
    }
    if (is_lazy) work_.choose_rolled(request, 0);
    for (std::uint32_t place = 0; place < work_.action_rows.size(); ++place) {
      const bool rolls = !is_lazy || std::binary_search(work_.rolled.begin(), work_.rolled.end(), place);
      if (!expand(work_.action_rows[place], count, request, rolls)) return Status::kDeadline;
    }
    return work_.rollout.met_nan() ? Status::kModelNan : Status::kOk;
  }

 private:
  using Fixed = typename M::Fixed;
  using State = typename M::State;
  using History = typename M::History;

  SearchDraws draws(std::size_t member, int depth) {
    return work_.draws(static_cast<std::uint32_t>(member), depth);
  }

  // Steps members; false if the deadline has passed.
  bool step(int action, const CpuMember<M>* members, std::size_t count, int depth) {
    for (std::size_t i = 0; i < count; ++i) {
      if (work_.clock.add(1)) return false;
      SearchDraws words = draws(i, depth);
      const StepResult result =
          M::step(work_.params, work_.fixed(members[i]), members[i].state, action, words, nexts_[i]);
      work_.rollout.note_error(is_broken<M>(result));
      work_.outcomes[i].reward = result.reward;
      work_.outcomes[i].terminal = result.terminal;
      work_.outcomes[i].bounds = {0, 0};
    }
    return true;
  }

  // The row of an action of which only the steps are known, with upper bounds if actions are to be chosen by it.
  ActionRow first_row(int action, std::size_t count, const LeafRequest& request, bool is_lazy) {
    ActionRow row{};
    row.action = action;
    WideSum rewards = 0, upper = 0;
    for (std::size_t i = 0; i < count; ++i) {
      rewards += work_.outcomes[i].reward;
      if (is_lazy && !work_.outcomes[i].terminal)
        upper += bounds(i, nexts_[i], work_.history, request.depth, false).upper;
    }
    row.reward_sum = spread(rewards, request.count, count);
    row.upper_sum = spread(upper, request.count, count);
    return row;
  }

  // Steps members and parts them into groups; false if the deadline has passed.
  bool make_groups(int action, const CpuMember<M>* members, std::size_t count, int depth) {
    if (!step(action, members, count, depth)) return false;
    const bool depended = depends_on_draws_;
    if (!part(action, members, count, depth)) return false;
    return depended == depends_on_draws_ || part(action, members, count, depth);
  }

  bool part(int action, const CpuMember<M>* members, std::size_t count, int depth) {
    const auto observe = [&](std::size_t i) {
      SearchDraws words = draws(i, depth);
      return M::observe(work_.params, work_.fixed(members[i]), members[i].state, action, words, nexts_[i]);
    };
    const auto weigh = [&](std::size_t i, const typename M::Key& key, [[maybe_unused]] State& next) {
      SearchDraws words = draws(i, depth);
      WatchedDraws<SearchDraws> watched(words);
      const Fixed& fixed = work_.fixed(members[i]);
      double density = 0.0;
      if constexpr (kKeyHoldsState<M>) {
        density = M::filter(work_.params, fixed, members[i].state, action, key, watched, next);
      } else {
        density =
            M::observation_density(work_.params, fixed, members[i].state, action, key, watched, nexts_[i]);
      }
      depends_on_draws_ |= watched.is_read();
      return density;
    };
    // Members to which all observations are as likely: those of the same states, unless draws of the step count too.
    const auto alike = [&](std::size_t i, std::size_t j) {
      return !depends_on_draws_ && is_same(nexts_[i], nexts_[j]) &&
             is_same(members[i].state, members[j].state) &&
             is_same(work_.fixed(members[i]), work_.fixed(members[j]));
    };
    return groups_.make(
        count, [&](std::size_t i) { return work_.outcomes[i].terminal; }, alike, observe, weigh,
        [&](std::size_t steps) { return work_.clock.add(steps); });
  }

  template <class T>
  static bool is_same(const T& a, const T& b) {
    return std::is_empty_v<T> || std::memcmp(&a, &b, sizeof a) == 0;
  }

  // Appends the groups of an action to the rows, and sums them; false if the deadline has passed.
  bool expand(ActionRow& row, std::size_t count, const LeafRequest& request, bool rolls) {
    row.first_child = work_.child_rows.size();
    if (!make_groups(row.action, work_.members.data(), count, request.depth)) return false;
    const bool remembers = M::kHasHistory && rolls;
    after_.clear();
    for (std::uint32_t g = 0; remembers && g < groups_.count(); ++g) {
      after_.emplace_back();
      see(row.action, work_.members.data(), groups_.first(g), request.depth, work_.history, after_.back());
    }
    if (!bound_members(count, request.depth, rolls)) return false;
    const std::uint64_t mass = request.count, whole = std::uint64_t{count} * kWholeShare;
    std::uint64_t reached = 0, before = 0;
    const auto append = [&](std::uint32_t first, std::uint64_t shares, bool terminal) -> ChildRow& {
      reached += shares;
      const auto now = static_cast<std::uint64_t>(static_cast<WideSum>(mass) * reached / whole);
      work_.child_rows.allocate(1);  // always fits: there is room for a group of each member
      ChildRow& child = work_.child_rows[row.first_child + row.child_count++];
      child = empty_row(first, static_cast<std::uint32_t>(now - before), terminal);
      before = now;
      return child;
    };
    for (std::uint32_t g = 0; g < groups_.count(); ++g) {
      std::uint64_t shares = 0;
      WideSum upper = 0, lower = 0;
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t share = work_.outcomes[i].terminal ? 0 : groups_.share(g, i);
        if (share == 0) continue;
        const ScenarioBounds found =
            bounds_in(g, i, remembers ? after_[g] : work_.history, request.depth, rolls);
        shares += share;
        upper += static_cast<WideSum>(found.upper) * share;
        lower += static_cast<WideSum>(found.lower) * share;
      }
      ChildRow& child = append(groups_.first(g), shares, false);
      child.upper_sum = spread(upper, mass, whole);
      child.lower_sum = spread(lower, mass, whole);
    }
    if (reached < whole) append(first_terminal(count), whole - reached, true);
    work_.add_bounds(row);
    return !work_.clock.is_over();
  }

  // Fills in bounds of the members' successors; false if the deadline has passed. A member is rolled out with the
  // history of its likeliest group.
  bool bound_members(std::size_t count, int depth, bool rolls) {
    const auto after = [&](std::size_t i) -> const History& {
      return M::kHasHistory && rolls ? after_[groups_.likeliest(i)] : work_.history;
    };
    const bool waits = rolls && work_.rollout.in_lanes(depth + 1, count);
    for (std::size_t i = 0; i < count;) {
      const std::size_t first = i;
      for (; i < count && !(waits && !work_.rollout.has_room(1)); ++i) {
        if (work_.outcomes[i].terminal) continue;
        ScenarioBounds& found = work_.outcomes[i].bounds;
        const CpuMember<M>& member = work_.members[i];
        found = waits ? work_.rollout.begin(work_.fixed(member), member.scenario, nexts_[i], after(i),
                                            static_cast<std::uint32_t>(i))
                      : bounds(i, nexts_[i], after(i), depth, rolls);
      }
      if (!waits) break;
      if (!work_.rollout.play(work_.scene.fixed.data(), depth + 1)) return false;
      for (std::size_t k = first; k < i; ++k) {
        CpuOutcome<M>& outcome = work_.outcomes[k];
        if (!outcome.terminal) outcome.bounds.lower = work_.rollout.end(outcome.bounds);
      }
    }
    return true;
  }

  std::uint32_t first_terminal(std::size_t count) const {
    std::uint32_t i = 0;
    while (i < count && !work_.outcomes[i].terminal) ++i;
    return i;
  }

  // A member's bounds in a group, which may see another state than the member's own.
  ScenarioBounds bounds_in(std::uint32_t group, std::size_t i, const History& after, int depth, bool rolls) {
    const State* const next = groups_.next(group, i);
    const bool is_other = next != nullptr && !is_same(*next, nexts_[i]);
    return is_other ? bounds(i, *next, after, depth, rolls) : work_.outcomes[i].bounds;
  }

  // Bounds of a member's successor: with a rollout, or the floor for a lower one.
  ScenarioBounds bounds(std::size_t i, const State& next, const History& after, int depth, bool rolls) {
    const Fixed& fixed = work_.fixed(work_.members[i]);
    return rolls ? work_.rollout.bounds(fixed, next, after, static_cast<std::uint32_t>(i), depth + 1)
                 : work_.rollout.cheap_bounds(fixed, next, depth + 1);
  }

  // The history after what member i sees.
  void see(int action, const CpuMember<M>* members, std::size_t i, int depth, const History& before,
           History& after) {
    SearchDraws words = draws(i, depth);
    const Fixed& fixed = work_.fixed(members[i]);
    const typename M::Key key = M::observe(work_.params, fixed, members[i].state, action, words, nexts_[i]);
    M::advance_history(work_.params, fixed, members[i].state, action, key, nexts_[i], before, after);
  }

  LeafWork<M>& work_;
  WeightedGroups<M> groups_;
  std::vector<State> nexts_;       // after the action in work, by member
  std::vector<History> after_;     // by group
  bool depends_on_draws_ = false;  // how likely observations are, besides states
};

}  // namespace hypgen
