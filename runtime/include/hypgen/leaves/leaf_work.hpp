// SPDX-License-Identifier: Apache-2.0
// What one thread of a search expands a leaf with on the host.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "hypgen/leaves/cpu_scene.hpp"
#include "hypgen/leaves/rolled_actions.hpp"
#include "hypgen/leaves/rollout.hpp"
#include "hypgen/leaves/step_clock.hpp"
#include "hypgen/memory/arena.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen {

// A thread's leaf in work: its members, the rows made so far, and what simulates the model.
template <class M>
struct LeafWork {
  using Node = CpuNode<M>;
  using Fixed = typename M::Fixed;
  using State = typename M::State;
  using History = typename M::History;

  explicit LeafWork(CpuScene<M>& shared)
      : scene(shared),
        params(shared.params),
        cursor(shared.pool),
        members(shared.options.max_scenarios),
        outcomes(shared.scratch.outcomes),
        cache(shared.options.max_scenarios, shared.scratch.cached_steps),
        rollout(params, cache, clock, shared.options),
        child_rows(M::kActionCount * shared.options.max_scenarios) {
    legal.reserve(M::kActionCount);
    promises_.reserve(M::kActionCount);
    rolled.reserve(M::kActionCount + 1);
    action_rows.reserve(M::kActionCount);
    gains.reserve(M::kActionCount);
  }

  LeafWork(const LeafWork&) = delete;
  LeafWork& operator=(const LeafWork&) = delete;

  // Forgets the previous search. The number i of a stream stands for `first + i`.
  void begin_search(std::uint32_t first) {
    cache.begin_search(scene.setup.key, first);
    rollout.begin_search(scene.setup);
    clock.begin_search(scene.setup.deadline);
    cursor.reset();
  }

  SearchDraws draws(std::uint32_t number, int depth) {
    return SearchDraws(cache, number, static_cast<std::uint32_t>(depth));
  }

  const Fixed& fixed(const CpuMember<M>& member) const { return scene.fixed[member.scenario]; }
  Node& node(std::uint64_t handle) { return scene.pool[Ref<Node>{static_cast<std::uint32_t>(handle)}]; }

  // Takes a node's members and history; gives their number.
  std::size_t load(Ref<Node> ref) {
    Node& from = scene.pool[ref];
    history = from.history;
    std::copy_n(from.members(), from.count, members.begin());
    return from.count;
  }

  // Stores the first `count` members and their history as a node; none if there is no room.
  Ref<Node> keep(std::size_t count) {
    const Ref<Node> ref = cursor.template take<Node>(Node::bytes(count));
    if (!ref) return ref;
    Node& made = *new (&scene.pool[ref]) Node{history, static_cast<std::uint32_t>(count)};
    std::copy_n(members.begin(), count, made.members());
    return ref;
  }

  void clear_rows() {
    action_rows.clear();
    gains.clear();
    child_rows.reset();
  }

  // Copies the leaf's rows to the pool, now that their number is known; false if there is no room.
  bool keep_rows(LeafResult& result) {
    const std::size_t actions = action_rows.size(), more = gains.size(), children = child_rows.size();
    if (actions == 0) return true;
    const Ref<ActionRow> block = cursor.template take<ActionRow>(
        actions * sizeof(ActionRow) + more * sizeof(Gain) + children * sizeof(ChildRow));
    if (!block) return false;
    ActionRow* const first = &scene.pool[block];
    auto* const first_gain = reinterpret_cast<Gain*>(std::copy_n(action_rows.begin(), actions, first));
    auto* const first_child = reinterpret_cast<ChildRow*>(std::copy_n(gains.begin(), more, first_gain));
    std::copy_n(&child_rows[0], children, first_child);
    result.actions = {first, actions};
    result.gains = {first_gain, more};
    result.children = {first_child, children};
    return true;
  }

  // Lists the legal actions. All members agree: legality reads visible variables alone.
  void list_legal(Span<const int> wanted) {
    const CpuMember<M>& any = members[0];
    const int count = wanted.empty() ? M::kActionCount : static_cast<int>(wanted.size());
    legal.clear();
    for (int i = 0; i < count; ++i) {
      const int action = wanted.empty() ? i : wanted[static_cast<std::size_t>(i)];
      if (M::is_legal(params, fixed(any), any.state, action)) legal.push_back(action);
    }
  }

  // Whether bounds of states at that depth take rollouts.
  bool rolls_out(int depth) const { return !M::kHasLower && depth < scene.setup.depth_limit; }

  // Fills `rolled` with the places of the actions to roll out, ascending: those that promise most, ties going to
  // the first, and the default policy's. The first member draws with `number`.
  void choose_rolled(const LeafRequest& request, std::uint32_t number) {
    promises_.clear();
    for (const ActionRow& row : action_rows) {
      promises_.push_back(promise(row.reward_sum, row.upper_sum, scene.options.discount));
    }
    rolled.clear();
    for (std::uint32_t n = 0; n < request.rolled && n < promises_.size(); ++n) {
      const auto best = std::max_element(promises_.begin(), promises_.end());
      if (!can_raise(*best, request.lower_sum)) break;
      rolled.push_back(static_cast<std::uint32_t>(best - promises_.begin()));
      *best = -std::numeric_limits<double>::infinity();
    }
    SearchDraws words = draws(number, request.depth);
    const int action = M::default_policy(params, fixed(members[0]), members[0].state, history, words);
    const auto place = std::lower_bound(legal.begin(), legal.end(), action);
    if (place != legal.end() && *place == action) {
      rolled.push_back(static_cast<std::uint32_t>(place - legal.begin()));
    }
    std::sort(rolled.begin(), rolled.end());
    rolled.erase(std::unique(rolled.begin(), rolled.end()), rolled.end());
  }

  // Sums an action's children.
  void add_bounds(ActionRow& row) {
    row.upper_sum = row.lower_sum = 0;
    for (std::uint32_t i = 0; i < row.child_count; ++i) {
      const ChildRow& child = child_rows[row.first_child + i];
      row.upper_sum += std::max(child.upper_sum, child.lower_sum);
      row.lower_sum += child.lower_sum;
    }
  }

  CpuScene<M>& scene;
  const typename M::Params& params;
  PoolCursor cursor;
  std::vector<CpuMember<M>> members;
  History history{};
  std::vector<CpuOutcome<M>> outcomes;
  std::vector<int> legal;
  std::vector<std::uint32_t> rolled;  // places of the actions that are rolled out
  std::vector<ActionRow> action_rows;
  std::vector<Gain> gains;
  DrawCache cache;
  StepClock clock;
  Rollout<M> rollout;
  Arena<ChildRow> child_rows;

 private:
  std::vector<double> promises_;  // by place in `legal`
};

}  // namespace hypgen
