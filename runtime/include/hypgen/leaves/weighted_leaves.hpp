// SPDX-License-Identifier: Apache-2.0
// Expands leaves whose groups share scenarios, with weights.
//
// A node's members are all as likely, and may repeat a scenario. Each draws under its place in the node, so copies
// part again. After an action, `WeightedGroups` gives each member a share in a few groups. A group becomes a node by
// drawing members by their shares.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "hypgen/leaves/leaf_work.hpp"
#include "hypgen/leaves/weighted_parts.hpp"
#include "hypgen/leaves/weighted_sums.hpp"

namespace hypgen {

template <class M>
class WeightedLeaves {
 public:
  explicit WeightedLeaves(LeafWork<M>& work) : work_(work), parts_(work.scene.options.max_scenarios) {
    after_.reserve(work.scene.options.max_scenarios);
  }

  // Forgets the previous search, so that results do not depend on it.
  void begin_search() { parts_.begin_search(); }

  // Draws the members of a group of an action of `request.parent`; gives their number, or 0 if there is no such group
  // or the deadline has passed.
  std::size_t draw_members(const LeafRequest& request) {
    CpuNode<M>& parent = work_.node(request.parent);
    const CpuMember<M>* const from = parent.members();
    const int depth = request.depth - 1;
    if (!make_groups(request.action, from, parent.count, depth)) return 0;
    const std::uint32_t group = groups_.named(request.first);
    if (group == groups_.count()) return 0;
    const std::size_t drawn = parts_.draw(group, request.count, work_.cache.key(), request.action, depth,
                                          from, parent.count, work_.members.data());
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

  // Steps members; false if the deadline has passed.
  bool step(int action, const CpuMember<M>* members, std::size_t count, int depth) {
    return parts_.step(work_, action, members, count, depth, [&](std::size_t i, const StepResult& result) {
      work_.rollout.note_error(is_broken<M>(result));
      work_.outcomes[i].reward = result.reward;
      work_.outcomes[i].terminal = result.terminal;
      work_.outcomes[i].bounds = {0, 0};
    });
  }

  // The row of an action of which only the steps are known, with upper bounds if actions are to be chosen by it.
  ActionRow first_row(int action, std::size_t count, const LeafRequest& request, bool is_lazy) {
    ActionRow row{};
    row.action = action;
    WideSum rewards = 0, upper = 0;
    for (std::size_t i = 0; i < count; ++i) {
      rewards += work_.outcomes[i].reward;
      if (is_lazy && !work_.outcomes[i].terminal)
        upper += bounds(i, parts_.next(i), work_.history, request.depth, false).upper;
    }
    row.reward_sum = spread(rewards, request.count, count);
    row.upper_sum = spread(upper, request.count, count);
    return row;
  }

  // Steps members and parts them into groups; false if the deadline has passed.
  bool make_groups(int action, const CpuMember<M>* members, std::size_t count, int depth) {
    return step(action, members, count, depth) &&
           parts_.part(work_, action, members, count, depth,
                       [&](std::size_t i) { return work_.outcomes[i].terminal; });
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
        found = waits ? work_.rollout.begin(work_.fixed(member), member.scenario, parts_.next(i), after(i),
                                            static_cast<std::uint32_t>(i))
                      : bounds(i, parts_.next(i), after(i), depth, rolls);
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
    const bool is_other = next != nullptr && !WeightedParts<M>::is_same(*next, parts_.next(i));
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
    const Fixed& fixed = work_.fixed(members[i]);
    const typename M::Key key = parts_.seen(work_, action, members, i, depth);
    M::advance_history(work_.params, fixed, members[i].state, action, key, parts_.next(i), before, after);
  }

  LeafWork<M>& work_;
  WeightedParts<M> parts_;  // of the action in work
  const WeightedGroups<M>& groups_ = parts_.groups();
  std::vector<History> after_;  // by group
};

}  // namespace hypgen
