// SPDX-License-Identifier: Apache-2.0
// Expands leaves on the host, for one thread of a search.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "hypgen/leaves/grouping.hpp"
#include "hypgen/leaves/leaf_work.hpp"
#include "hypgen/leaves/weighted_leaves.hpp"

namespace hypgen {

// One thread's worker. Of each expanded leaf it keeps the history and the members: scenario numbers and
// states. To expand a child it simulates the child's action over the parent's members again. Apart from new
// blocks of the pool a worker writes only its own data.
template <class M>
class CpuWorker : LeafWork<M> {
  using Work = LeafWork<M>;

 public:
  using typename Work::History, typename Work::State;

  explicit CpuWorker(CpuScene<M>& scene)
      : Work(scene), baseline_(scene.options.max_scenarios), grouping_(scene.options.max_scenarios) {
    rolled_actions_.reserve(M::kActionCount);
    if (M::kHasHistory) {
      after_.reserve(outcomes.size());
      after_of_.resize(outcomes.size());
    }
    if (scene.options.may_weigh) weighted_ = std::make_unique<WeightedLeaves<M>>(static_cast<Work&>(*this));
  }

  // Forgets the previous search. Scenario i draws with the number `first + i`.
  void begin_search(std::uint32_t first) {
    Work::begin_search(first);
    if (weighted_) weighted_->begin_search();
  }

  // Stores the root in the scene and computes its bounds.
  RootResult begin_root(const std::vector<State>& states, std::size_t count, const History& before) {
    if (!keep_root(states, count, before)) return {Status::kMemoryFull, {}, -1};
    return bound_root(count);
  }

  // Stores the root in the scene; false if there is no room.
  bool keep_root(const std::vector<State>& states, std::size_t count, const History& before) {
    history = before;
    for (std::uint32_t i = 0; i < count; ++i) members[i] = {i, states[i]};
    scene.root = keep(count);
    return static_cast<bool>(scene.root);
  }

  // Stores a group of an action of `request.parent` as a node without rows; none if there is no room or no such
  // group.
  Ref<CpuNode<M>> keep_child(const LeafRequest& request) {
    const std::size_t count = find_members(request);
    return count == request.count || (scene.setup.weighted && count > 0) ? keep(count) : Ref<CpuNode<M>>{};
  }

  LeafResult expand(const LeafRequest& request) {
    LeafResult result;
    result.ticket = request.ticket;
    result.status = evaluate(request, result);
    if (result.status == Status::kOk && !keep_rows(result)) result.status = Status::kMemoryFull;
    if (result.status == Status::kOk) ++leaves_;
    return result;
  }

  void release() { cursor.reset(); }

  // Of the thread that answers.
  void learn_pauses() { clock.learn_pauses(); }

  std::uint64_t leaves() const { return leaves_; }
  std::uint64_t steps() const { return clock.steps(); }

 private:
  using typename Work::Fixed, typename Work::Node;
  using Member = CpuMember<M>;
  using Outcome = CpuOutcome<M>;
  using Work::action_rows, Work::cache, Work::child_rows, Work::clock, Work::cursor, Work::gains,
      Work::history, Work::legal, Work::members, Work::outcomes, Work::params, Work::rolled, Work::rollout,
      Work::scene;
  using Work::add_bounds, Work::choose_rolled, Work::draws, Work::fixed, Work::keep, Work::keep_rows,
      Work::list_legal, Work::rolls_out;

  RootResult bound_root(std::size_t count) {
    PhiloxDraws first(cache.key(), 0, 0);
    const std::size_t mass = scene.setup.weighted ? count * kScenarioMass : count;
    RootResult result{Status::kOk, empty_row(0, static_cast<std::uint32_t>(mass), false), -1};
    result.default_action = M::default_policy(params, scene.fixed[0], members[0].state, history, first);
    if (rollout.in_lanes(0, count)) {
      bound_root_in_lanes(count, result);
      count = 0;
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      const ScenarioBounds bounds = rollout.bounds(scene.fixed[i], members[i].state, history, i, 0);
      result.row.upper_sum += bounds.upper;
      result.row.lower_sum += bounds.lower;
      if (clock.is_over()) result.status = Status::kDeadline;
      if (result.status != Status::kOk) break;
    }
    if (rollout.met_nan()) result.status = Status::kModelNan;
    return result;
  }

  void bound_root_in_lanes(std::size_t count, RootResult& result) {
    for (std::uint32_t i = 0; i < count;) {
      const std::uint32_t first = i;
      for (; i < count && rollout.has_room(1); ++i) {
        outcomes[i].bounds = rollout.begin(scene.fixed[i], i, members[i].state, history, i);
      }
      if (!rollout.play(scene.fixed.data(), 0)) result.status = Status::kDeadline;
      if (result.status != Status::kOk) return;
      for (std::uint32_t k = first; k < i; ++k) {
        result.row.upper_sum += outcomes[k].bounds.upper;
        result.row.lower_sum += rollout.end(outcomes[k].bounds);
      }
    }
  }

  // Makes the leaf's rows in action_rows, child_rows and gains, and keeps its node.
  Status evaluate(const LeafRequest& request, LeafResult& result) {
    const bool is_root = request.parent == kNoHandle;
    const bool rolls_all = request.rolled == kRollsAll || !rollout.has_floor();
    const std::size_t count = is_root ? this->load(scene.root) : find_members(request);
    if (clock.is_over()) return Status::kDeadline;
    if (count == 0 || (!scene.setup.weighted && count != request.count)) return Status::kEvaluatorFailed;
    const Ref<Node> node = is_root ? scene.root : keep(count);
    if (!node) return Status::kMemoryFull;
    result.handle = node.units;
    result.count = static_cast<std::uint32_t>(count);
    list_legal(request.actions);
    this->clear_rows();
    const bool is_lazy = !rolls_all && rolls_out(request.depth + 1);
    if (scene.setup.weighted) return weighted_->evaluate(request, count, is_lazy);
    const bool has_gains = is_root && request.rolled == kRollsAll;
    if (has_gains && !set_baseline(count)) return Status::kDeadline;
    const auto add = [&](int action, const Outcome* found) {
      reduce(action, found, count);
      if (has_gains) add_gain(found, count);
    };
    if (!simulate_blocks(legal, count, request.depth, !is_lazy, add)) return Status::kDeadline;
    if (is_lazy) {
      choose_rolled(request, members[0].scenario);
      rolled_actions_.clear();
      for (const std::uint32_t at : rolled) rolled_actions_.push_back(legal[at]);
      std::size_t next = 0;
      const auto raise = [&](int, const Outcome* found) { raise_lowers(rolled[next++], found, count); };
      if (!simulate_blocks(rolled_actions_, count, request.depth, true, raise)) return Status::kDeadline;
    }
    return rollout.met_nan() ? Status::kModelNan : Status::kOk;
  }

  // Simulates as many of the actions at once as outcomes fit and gives each action's outcomes to `take`;
  // false if the deadline has passed.
  template <class Take>
  bool simulate_blocks(const std::vector<int>& actions, std::size_t count, int depth, bool rolls, Take take) {
    const std::size_t block = std::max<std::size_t>(1, outcomes.size() / count);
    for (std::size_t first = 0; first < actions.size(); first += block) {
      const Span<const int> some(actions.data() + first, std::min(block, actions.size() - first));
      if (!(rolls ? simulate<true>(some, count, depth) : simulate<false>(some, count, depth))) return false;
      for (std::size_t a = 0; a < some.size(); ++a) take(some[a], outcomes.data() + a * count);
    }
    return true;
  }

  // Simulates the request's action over the parent's members. Takes the members that see what member `first`
  // sees, and the history after that observation; gives their number, or 0 if the deadline has passed.
  [[gnu::noinline]] std::size_t find_members(const LeafRequest& request) {
    if (scene.setup.weighted) return weighted_->draw_members(request);
    Node& parent = this->node(request.parent);
    const Member* const above = parent.members();
    typename M::Key wanted{};
    std::size_t count = 0;
    for (std::uint32_t i = request.first; i < parent.count && count < request.count; ++i) {
      const Member& from = above[i];
      const Fixed& own = fixed(from);
      SearchDraws words = draws(from.scenario, request.depth - 1);
      State next;
      if (clock.add(1)) return 0;
      if (M::step(params, own, from.state, request.action, words, next).terminal) {
        if (count == 0) return 0;
        continue;
      }
      const typename M::Key key = M::observe(params, own, from.state, request.action, words, next);
      if (count == 0) {
        wanted = key;
        if (M::kHasHistory) {
          M::advance_history(params, own, from.state, request.action, key, next, parent.history, history);
        }
      }
      if (key == wanted) members[count++] = {from.scenario, next};
    }
    return count;
  }

  // Fills outcomes, action by action; false if the deadline has passed. This and find_members are not
  // inlined: in one function with the rest the rollout's loop loses its registers and a fifth of its speed.
  // `rolls`: successors are rolled out, or looked up where the model declares a lower bound.
  template <bool rolls>
  [[gnu::noinline]] bool simulate(Span<const int> actions, std::size_t count, int depth) {
    if (M::kHasHistory && rolls && !make_histories(actions, count, depth)) return false;
    const bool waits = rolls && rollout.in_lanes(depth + 1, count * actions.size());
    std::size_t first_waiting = 0;  // member
    for (std::size_t i = 0; i < count; ++i) {
      if (waits && !rollout.has_room(actions.size())) {
        if (!end_rollouts(actions, first_waiting, i, count, depth)) return false;
        first_waiting = i;
      }
      const Member member = members[i];
      const Fixed& own = fixed(member);
      SearchDraws words = draws(member.scenario, depth);
      memo_.clear();
      for (std::size_t a = 0; a < actions.size(); ++a) {
        if (clock.add(1)) return false;
        Outcome& outcome = outcomes[a * count + i];
        State next;
        const StepResult step = M::step(params, own, member.state, actions[a], words, next);
        rollout.note_error(is_broken<M>(step));
        outcome.reward = step.reward;
        outcome.key = {};
        outcome.bounds = {0, 0};
        outcome.terminal = step.terminal;
        if (step.terminal) continue;
        outcome.key = M::observe(params, own, member.state, actions[a], words, next);
        if constexpr (rolls) {
          const History& after = M::kHasHistory ? after_[after_of_[a * count + i]] : history;
          outcome.bounds = memo_.find_or(next, after, [&] {
            return waits ? rollout.begin(own, member.scenario, next, after, member.scenario)
                         : rollout.bounds(own, next, after, member.scenario, depth + 1);
          });
        } else {
          outcome.bounds =
              memo_.find_or(next, history, [&] { return rollout.cheap_bounds(own, next, depth + 1); });
        }
      }
    }
    if (waits) return end_rollouts(actions, first_waiting, count, count, depth);
    return !clock.is_over();  // the last rollout may have been cut off
  }

  // Plays the rollouts that outcomes of the members from `first` to before `end` wait for; false if the deadline
  // has passed.
  bool end_rollouts(Span<const int> actions, std::size_t first, std::size_t end, std::size_t count,
                    int depth) {
    if (!rollout.play(scene.fixed.data(), depth + 1)) return false;
    for (std::size_t a = 0; a < actions.size(); ++a) {
      for (std::size_t i = first; i < end; ++i) {
        Outcome& outcome = outcomes[a * count + i];
        if (!outcome.terminal) outcome.bounds.lower = rollout.end(outcome.bounds);
      }
    }
    return true;
  }

  // Fills after_ with the history of each group of each action, and after_of_ with the group of each outcome;
  // false if the deadline has passed.
  bool make_histories(Span<const int> actions, std::size_t count, int depth) {
    after_.clear();
    for (std::size_t a = 0; a < actions.size(); ++a) {
      const std::size_t first = after_.size();
      grouping_.clear();
      for (std::size_t i = 0; i < count; ++i) {
        const Member& member = members[i];
        const Fixed& own = fixed(member);
        SearchDraws words = draws(member.scenario, depth);
        State next;
        if (clock.add(1)) return false;
        if (M::step(params, own, member.state, actions[a], words, next).terminal) continue;
        const typename M::Key key = M::observe(params, own, member.state, actions[a], words, next);
        const std::size_t group = first + grouping_.number(false, key);
        if (group == after_.size()) {
          after_.emplace_back();
          M::advance_history(params, own, member.state, actions[a], key, next, history, after_.back());
        }
        after_of_[a * count + i] = static_cast<std::uint32_t>(group);
      }
    }
    return true;
  }

  // Sets baseline_ to the one-ply returns of the default policy's action; false if the deadline has passed.
  bool set_baseline(std::size_t count) {
    PhiloxDraws first(cache.key(), 0, 0);
    const int action = M::default_policy(params, scene.fixed[0], members[0].state, history, first);
    std::fill_n(baseline_.begin(), count, 0);
    if (action < 0) return true;
    if (!simulate<true>({&action, 1}, count, 0)) return false;
    for (std::size_t i = 0; i < count; ++i) baseline_[i] = one_ply_return(outcomes[i]);
    return true;
  }

  std::int64_t one_ply_return(const Outcome& outcome) const {
    return outcome.reward +
           static_cast<std::int64_t>(scene.options.discount * static_cast<double>(outcome.bounds.lower));
  }

  // Sums an action's outcomes by group, and appends the action's rows.
  void reduce(int action, const Outcome* found, std::size_t count) {
    const std::uint32_t first = child_rows.size();
    ActionRow row{};
    row.action = action;
    row.first_child = action_rows.empty() ? 0 : next_child(action_rows.back());
    grouping_.clear();
    for (std::size_t i = 0; i < count; ++i) {
      const Outcome& outcome = found[i];
      const std::uint32_t group = grouping_.number(outcome.terminal, outcome.key);
      if (group == row.child_count) {
        child_rows.allocate(1);  // always fits: there is room for a group of each scenario
        ++row.child_count;
        child_rows[first + group] = empty_row(static_cast<std::uint32_t>(i), 0, outcome.terminal);
      }
      ChildRow& child = child_rows[first + group];
      ++child.count;
      child.upper_sum += outcome.bounds.upper;
      child.lower_sum += outcome.bounds.lower;
      row.reward_sum += outcome.reward;
    }
    add_bounds(row);
    action_rows.push_back(row);
  }

  // Replaces the lower bounds of an action's row, which were floors, by those of its rolled-out outcomes. Its
  // groups are the same, in the same order.
  void raise_lowers(std::uint32_t place, const Outcome* found, std::size_t count) {
    ActionRow& row = action_rows[place];
    ChildRow* const children = &child_rows[row.first_child];
    for (std::uint32_t i = 0; i < row.child_count; ++i) children[i].lower_sum = 0;
    grouping_.clear();
    for (std::size_t i = 0; i < count; ++i) {
      children[grouping_.number(found[i].terminal, found[i].key)].lower_sum += found[i].bounds.lower;
    }
    add_bounds(row);
  }

  static std::uint32_t next_child(const ActionRow& row) { return row.first_child + row.child_count; }

  // Appends an action's gain over the default policy's action.
  void add_gain(const Outcome* found, std::size_t count) {
    Gain total{0, 0.0};
    for (std::size_t i = 0; i < count; ++i) {
      const std::int64_t gain = one_ply_return(found[i]) - baseline_[i];
      total.sum += gain;
      total.square_sum += from_fixed_sum<kRewardBits<M>>(gain) * from_fixed_sum<kRewardBits<M>>(gain);
    }
    gains.push_back(total);
  }

  std::uint64_t leaves_ = 0;  // of all searches

  // The leaf in work.
  std::vector<History> after_;           // of each group of each action
  std::vector<std::uint32_t> after_of_;  // of each outcome: an index into after_
  std::vector<std::int64_t> baseline_;
  std::vector<int> rolled_actions_;
  ActionGrouping<typename M::Key> grouping_;
  BoundsMemo<M> memo_;
  std::unique_ptr<WeightedLeaves<M>> weighted_;  // null: no search weighs
};

}  // namespace hypgen
