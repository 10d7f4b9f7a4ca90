// SPDX-License-Identifier: Apache-2.0
// Expands leaves on the host, for one thread of a search.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "hypgen/leaves/cpu_scene.hpp"
#include "hypgen/leaves/grouping.hpp"
#include "hypgen/leaves/rolled_actions.hpp"
#include "hypgen/leaves/rollout.hpp"
#include "hypgen/leaves/step_clock.hpp"
#include "hypgen/memory/arena.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen {

// One thread's worker. Of each expanded leaf it keeps the history and the members: scenario numbers and
// states. To expand a child it simulates the child's action over the parent's members again. Apart from new
// blocks of the pool a worker writes only its own data.
template <class M>
class CpuWorker {
 public:
  explicit CpuWorker(CpuScene<M>& scene)
      : scene_(scene),
        params_(scene.params),
        fixed_(scene.fixed),
        cursor_(scene.pool),
        members_(scene.options.max_scenarios),
        baseline_(scene.options.max_scenarios),
        outcomes_(scene.scratch.outcomes),
        grouping_(scene.options.max_scenarios),
        cache_(scene.options.max_scenarios, scene.scratch.cached_steps),
        rollout_(params_, cache_, clock_, scene.options.discount, scene.options.max_depth),
        child_rows_(M::kActionCount * scene.options.max_scenarios) {
    legal_.reserve(M::kActionCount);
    promises_.reserve(M::kActionCount);
    rolled_.reserve(M::kActionCount + 1);
    rolled_actions_.reserve(M::kActionCount);
    action_rows_.reserve(M::kActionCount);
    gains_.reserve(M::kActionCount);
    if (M::kHasHistory) {
      after_.reserve(outcomes_.size());
      after_of_.resize(outcomes_.size());
    }
  }

  CpuWorker(const CpuWorker&) = delete;
  CpuWorker& operator=(const CpuWorker&) = delete;

  // Forgets the previous search. Scenario i draws with the number `first + i`.
  void begin_search(std::uint32_t first) {
    cache_.begin_search(scene_.setup.key, first);
    rollout_.begin_search(scene_.setup);
    clock_.begin_search(scene_.setup.deadline);
    cursor_.reset();
  }

  // Stores the root in the scene and computes its bounds.
  RootResult begin_root(const std::vector<typename M::State>& states, std::size_t count,
                        const typename M::History& history) {
    if (!keep_root(states, count, history)) return {Status::kMemoryFull, {}, -1};
    return bound_root(count);
  }

  // Stores the root in the scene; false if there is no room.
  bool keep_root(const std::vector<typename M::State>& states, std::size_t count,
                 const typename M::History& history) {
    history_ = history;
    for (std::uint32_t i = 0; i < count; ++i) members_[i] = {i, states[i]};
    scene_.root = keep(count);
    return static_cast<bool>(scene_.root);
  }

  // Stores a group of an action of `request.parent` as a node without rows; none if there is no room or no such
  // group.
  Ref<CpuNode<M>> keep_child(const LeafRequest& request) {
    const std::size_t count = find_members(request);
    return count == request.count ? keep(count) : Ref<CpuNode<M>>{};
  }

  LeafResult expand(const LeafRequest& request) {
    LeafResult result;
    result.ticket = request.ticket;
    result.count = request.count;
    result.status = evaluate(request, result.handle);
    if (result.status == Status::kOk && !keep_rows(result)) result.status = Status::kMemoryFull;
    if (result.status == Status::kOk) ++leaves_;
    return result;
  }

  void release() { cursor_.reset(); }

  // Of the thread that answers.
  void learn_pauses() { clock_.learn_pauses(); }

  std::uint64_t leaves() const { return leaves_; }
  std::uint64_t steps() const { return clock_.steps(); }

 private:
  using Member = CpuMember<M>;
  using Node = CpuNode<M>;
  using Outcome = CpuOutcome<M>;

  SearchDraws draws(std::uint32_t scenario, int depth) {
    return SearchDraws(cache_, scenario, static_cast<std::uint32_t>(depth));
  }

  RootResult bound_root(std::size_t count) {
    PhiloxDraws first(cache_.key(), 0, 0);
    RootResult result{Status::kOk, empty_row(0, static_cast<std::uint32_t>(count), false), -1};
    result.default_action = M::default_policy(params_, fixed_[0], members_[0].state, history_, first);
    for (std::uint32_t i = 0; i < count; ++i) {
      const ScenarioBounds bounds = rollout_.bounds(fixed_[i], members_[i].state, history_, i, 0);
      result.row.upper_sum += bounds.upper;
      result.row.lower_sum += bounds.lower;
      if (clock_.is_over()) result.status = Status::kDeadline;
      if (result.status != Status::kOk) break;
    }
    if (rollout_.met_nan()) result.status = Status::kModelNan;
    return result;
  }

  // Makes the leaf's rows in action_rows_, child_rows_ and gains_, and keeps its node.
  Status evaluate(const LeafRequest& request, std::uint64_t& handle) {
    const bool is_root = request.parent == kNoHandle;
    const bool rolls_all = request.rolled == kRollsAll || !rollout_.has_floor();
    const std::size_t count = is_root ? load(scene_.root) : find_members(request);
    if (clock_.is_over()) return Status::kDeadline;
    if (count == 0 || count != request.count) return Status::kEvaluatorFailed;
    const Ref<Node> node = is_root ? scene_.root : keep(count);
    if (!node) return Status::kMemoryFull;
    handle = node.units;
    list_legal(request.actions);
    action_rows_.clear();
    gains_.clear();
    child_rows_.reset();
    const bool has_gains = is_root && request.rolled == kRollsAll;
    if (has_gains && !set_baseline(count)) return Status::kDeadline;
    const bool is_lazy = !rolls_all && rolls_out(request.depth + 1);
    const auto add = [&](int action, const Outcome* outcomes) {
      reduce(action, outcomes, count);
      if (has_gains) add_gain(outcomes, count);
    };
    if (!simulate_blocks(legal_, count, request.depth, !is_lazy, add)) return Status::kDeadline;
    if (is_lazy) {
      choose_rolled(request);
      std::size_t next = 0;
      const auto raise = [&](int, const Outcome* outcomes) {
        raise_lowers(rolled_[next++], outcomes, count);
      };
      if (!simulate_blocks(rolled_actions_, count, request.depth, true, raise)) return Status::kDeadline;
    }
    return rollout_.met_nan() ? Status::kModelNan : Status::kOk;
  }

  // Whether bounds of states at that depth take rollouts.
  bool rolls_out(int depth) const { return !M::kHasLower && depth < scene_.setup.depth_limit; }

  // Simulates as many of the actions at once as outcomes fit and gives each action's outcomes to `take`;
  // false if the deadline has passed.
  template <class Take>
  bool simulate_blocks(const std::vector<int>& actions, std::size_t count, int depth, bool rolls, Take take) {
    const std::size_t block = std::max<std::size_t>(1, outcomes_.size() / count);
    for (std::size_t first = 0; first < actions.size(); first += block) {
      const Span<const int> some(actions.data() + first, std::min(block, actions.size() - first));
      if (!(rolls ? simulate<true>(some, count, depth) : simulate<false>(some, count, depth))) return false;
      for (std::size_t a = 0; a < some.size(); ++a) take(some[a], outcomes_.data() + a * count);
    }
    return true;
  }

  // Fills rolled_ with the places of the actions to roll out, ascending, and rolled_actions_ with the
  // actions: those that promise most, ties going to the first, and the default policy's.
  void choose_rolled(const LeafRequest& request) {
    promises_.clear();
    for (const ActionRow& row : action_rows_) {
      promises_.push_back(promise(row.reward_sum, row.upper_sum, scene_.options.discount));
    }
    rolled_.clear();
    for (std::uint32_t n = 0; n < request.rolled && n < promises_.size(); ++n) {
      const auto best = std::max_element(promises_.begin(), promises_.end());
      if (!can_raise(*best, request.lower_sum)) break;
      rolled_.push_back(static_cast<std::uint32_t>(best - promises_.begin()));
      *best = -std::numeric_limits<double>::infinity();
    }
    const Member& any = members_[0];
    SearchDraws words = draws(any.scenario, request.depth);
    const int action = M::default_policy(params_, fixed_[any.scenario], any.state, history_, words);
    const auto place = std::lower_bound(legal_.begin(), legal_.end(), action);
    if (place != legal_.end() && *place == action) {
      rolled_.push_back(static_cast<std::uint32_t>(place - legal_.begin()));
    }
    std::sort(rolled_.begin(), rolled_.end());
    rolled_.erase(std::unique(rolled_.begin(), rolled_.end()), rolled_.end());
    rolled_actions_.clear();
    for (const std::uint32_t at : rolled_) rolled_actions_.push_back(legal_[at]);
  }

  std::size_t load(Ref<Node> ref) {
    Node& node = scene_.pool[ref];
    history_ = node.history;
    std::copy_n(node.members(), node.count, members_.begin());
    return node.count;
  }

  // Simulates the request's action over the parent's members. Takes the members that see what member `first`
  // sees, and the history after that observation; gives their number, or 0 if the deadline has passed.
  [[gnu::noinline]] std::size_t find_members(const LeafRequest& request) {
    Node& parent = scene_.pool[Ref<Node>{static_cast<std::uint32_t>(request.parent)}];
    const Member* const members = parent.members();
    typename M::Key wanted{};
    std::size_t count = 0;
    for (std::uint32_t i = request.first; i < parent.count && count < request.count; ++i) {
      const Member& from = members[i];
      const typename M::Fixed& fixed = fixed_[from.scenario];
      SearchDraws words = draws(from.scenario, request.depth - 1);
      typename M::State next;
      if (clock_.add(1)) return 0;
      if (M::step(params_, fixed, from.state, request.action, words, next).terminal) {
        if (count == 0) return 0;
        continue;
      }
      const typename M::Key key = M::observe(params_, fixed, from.state, request.action, words, next);
      if (count == 0) {
        wanted = key;
        if (M::kHasHistory) {
          M::advance_history(params_, fixed, from.state, request.action, key, next, parent.history, history_);
        }
      }
      if (key == wanted) members_[count++] = {from.scenario, next};
    }
    return count;
  }

  // Stores the first `count` of members_ and their history as a node; none if there is no room.
  Ref<Node> keep(std::size_t count) {
    const Ref<Node> ref = cursor_.template take<Node>(Node::bytes(count));
    if (!ref) return ref;
    Node& node = *new (&scene_.pool[ref]) Node{history_, static_cast<std::uint32_t>(count)};
    std::copy_n(members_.begin(), count, node.members());
    return ref;
  }

  // Copies the leaf's rows to the pool, now that their number is known; false if there is no room.
  bool keep_rows(LeafResult& result) {
    const std::size_t actions = action_rows_.size(), gains = gains_.size(), children = child_rows_.size();
    if (actions == 0) return true;
    const Ref<ActionRow> block = cursor_.template take<ActionRow>(
        actions * sizeof(ActionRow) + gains * sizeof(Gain) + children * sizeof(ChildRow));
    if (!block) return false;
    ActionRow* const first = &scene_.pool[block];
    auto* const first_gain = reinterpret_cast<Gain*>(std::copy_n(action_rows_.begin(), actions, first));
    auto* const first_child = reinterpret_cast<ChildRow*>(std::copy_n(gains_.begin(), gains, first_gain));
    std::copy_n(&child_rows_[0], children, first_child);
    result.actions = {first, actions};
    result.gains = {first_gain, gains};
    result.children = {first_child, children};
    return true;
  }

  // Lists the legal actions in legal_. All members agree: legality reads visible variables alone.
  void list_legal(Span<const int> wanted) {
    const Member& any = members_[0];
    const typename M::Fixed& fixed = fixed_[any.scenario];
    const int count = wanted.empty() ? M::kActionCount : static_cast<int>(wanted.size());
    legal_.clear();
    for (int i = 0; i < count; ++i) {
      const int action = wanted.empty() ? i : wanted[static_cast<std::size_t>(i)];
      if (M::is_legal(params_, fixed, any.state, action)) legal_.push_back(action);
    }
  }

  // Fills outcomes_, action by action; false if the deadline has passed. This and find_members are not
  // inlined: in one function with the rest the rollout's loop loses its registers and a fifth of its speed.
  // `rolls`: successors are rolled out, or looked up where the model declares a lower bound.
  template <bool rolls>
  [[gnu::noinline]] bool simulate(Span<const int> actions, std::size_t count, int depth) {
    if (M::kHasHistory && rolls && !make_histories(actions, count, depth)) return false;
    for (std::size_t i = 0; i < count; ++i) {
      const Member member = members_[i];
      const typename M::Fixed& fixed = fixed_[member.scenario];
      SearchDraws words = draws(member.scenario, depth);
      memo_.clear();
      for (std::size_t a = 0; a < actions.size(); ++a) {
        if (clock_.add(1)) return false;
        Outcome& outcome = outcomes_[a * count + i];
        typename M::State next;
        const StepResult step = M::step(params_, fixed, member.state, actions[a], words, next);
        rollout_.note_error(is_broken<M>(step));
        outcome.reward = step.reward;
        outcome.key = {};
        outcome.bounds = {0, 0};
        outcome.terminal = step.terminal;
        if (step.terminal) continue;
        outcome.key = M::observe(params_, fixed, member.state, actions[a], words, next);
        if constexpr (rolls) {
          const typename M::History& after = M::kHasHistory ? after_[after_of_[a * count + i]] : history_;
          outcome.bounds = memo_.find_or(
              next, after, [&] { return rollout_.bounds(fixed, next, after, member.scenario, depth + 1); });
        } else {
          outcome.bounds =
              memo_.find_or(next, history_, [&] { return rollout_.cheap_bounds(fixed, next, depth + 1); });
        }
      }
    }
    return !clock_.is_over();  // the last rollout may have been cut off
  }

  // Fills after_ with the history of each group of each action, and after_of_ with the group of each outcome;
  // false if the deadline has passed.
  bool make_histories(Span<const int> actions, std::size_t count, int depth) {
    after_.clear();
    for (std::size_t a = 0; a < actions.size(); ++a) {
      const std::size_t first = after_.size();
      grouping_.clear();
      for (std::size_t i = 0; i < count; ++i) {
        const Member& member = members_[i];
        const typename M::Fixed& fixed = fixed_[member.scenario];
        SearchDraws words = draws(member.scenario, depth);
        typename M::State next;
        if (clock_.add(1)) return false;
        if (M::step(params_, fixed, member.state, actions[a], words, next).terminal) continue;
        const typename M::Key key = M::observe(params_, fixed, member.state, actions[a], words, next);
        const std::size_t group = first + grouping_.number(false, key);
        if (group == after_.size()) {
          after_.emplace_back();
          M::advance_history(params_, fixed, member.state, actions[a], key, next, history_, after_.back());
        }
        after_of_[a * count + i] = static_cast<std::uint32_t>(group);
      }
    }
    return true;
  }

  // Sets baseline_ to the one-ply returns of the default policy's action; false if the deadline has passed.
  bool set_baseline(std::size_t count) {
    PhiloxDraws first(cache_.key(), 0, 0);
    const int action = M::default_policy(params_, fixed_[0], members_[0].state, history_, first);
    std::fill_n(baseline_.begin(), count, 0);
    if (action < 0) return true;
    if (!simulate<true>({&action, 1}, count, 0)) return false;
    for (std::size_t i = 0; i < count; ++i) baseline_[i] = one_ply_return(outcomes_[i]);
    return true;
  }

  std::int64_t one_ply_return(const Outcome& outcome) const {
    return outcome.reward +
           static_cast<std::int64_t>(scene_.options.discount * static_cast<double>(outcome.bounds.lower));
  }

  // Sums an action's outcomes by group, and appends the action's rows.
  void reduce(int action, const Outcome* outcomes, std::size_t count) {
    const std::uint32_t first = child_rows_.size();
    ActionRow row{};
    row.action = action;
    row.first_child = action_rows_.empty() ? 0 : next_child(action_rows_.back());
    grouping_.clear();
    for (std::size_t i = 0; i < count; ++i) {
      const Outcome& outcome = outcomes[i];
      const std::uint32_t group = grouping_.number(outcome.terminal, outcome.key);
      if (group == row.child_count) {
        child_rows_.allocate(1);  // always fits: there is room for a group of each scenario
        ++row.child_count;
        child_rows_[first + group] = empty_row(static_cast<std::uint32_t>(i), 0, outcome.terminal);
      }
      ChildRow& child = child_rows_[first + group];
      ++child.count;
      child.upper_sum += outcome.bounds.upper;
      child.lower_sum += outcome.bounds.lower;
      row.reward_sum += outcome.reward;
    }
    add_bounds(row);
    action_rows_.push_back(row);
  }

  // Replaces the lower bounds of an action's row, which were floors, by those of its rolled-out outcomes. Its
  // groups are the same, in the same order.
  void raise_lowers(std::uint32_t place, const Outcome* outcomes, std::size_t count) {
    ActionRow& row = action_rows_[place];
    ChildRow* const children = &child_rows_[row.first_child];
    for (std::uint32_t i = 0; i < row.child_count; ++i) children[i].lower_sum = 0;
    grouping_.clear();
    for (std::size_t i = 0; i < count; ++i) {
      children[grouping_.number(outcomes[i].terminal, outcomes[i].key)].lower_sum += outcomes[i].bounds.lower;
    }
    add_bounds(row);
  }

  // Sums an action's children.
  void add_bounds(ActionRow& row) {
    row.upper_sum = row.lower_sum = 0;
    for (std::uint32_t i = 0; i < row.child_count; ++i) {
      const ChildRow& child = child_rows_[row.first_child + i];
      row.upper_sum += std::max(child.upper_sum, child.lower_sum);
      row.lower_sum += child.lower_sum;
    }
  }

  static std::uint32_t next_child(const ActionRow& row) { return row.first_child + row.child_count; }

  // Appends an action's gain over the default policy's action.
  void add_gain(const Outcome* outcomes, std::size_t count) {
    Gain total{0, 0.0};
    for (std::size_t i = 0; i < count; ++i) {
      const std::int64_t gain = one_ply_return(outcomes[i]) - baseline_[i];
      total.sum += gain;
      total.square_sum += from_fixed_sum<kRewardBits<M>>(gain) * from_fixed_sum<kRewardBits<M>>(gain);
    }
    gains_.push_back(total);
  }

  CpuScene<M>& scene_;
  const typename M::Params& params_;
  const std::vector<typename M::Fixed>& fixed_;
  PoolCursor cursor_;
  std::uint64_t leaves_ = 0;  // of all searches

  // The leaf in work.
  std::vector<Member> members_;
  typename M::History history_{};
  std::vector<typename M::History> after_;  // of each group of each action
  std::vector<std::uint32_t> after_of_;     // of each outcome: an index into after_
  std::vector<std::int64_t> baseline_;
  std::vector<Outcome> outcomes_;
  std::vector<int> legal_;
  std::vector<double> promises_;       // by place in legal_
  std::vector<std::uint32_t> rolled_;  // places of the actions that are rolled out
  std::vector<int> rolled_actions_;    // these actions
  std::vector<ActionRow> action_rows_;
  std::vector<Gain> gains_;
  ActionGrouping<typename M::Key> grouping_;
  DrawCache cache_;
  StepClock clock_;
  Rollout<M> rollout_;
  BoundsMemo<M> memo_;
  Arena<ChildRow> child_rows_;
};

}  // namespace hypgen
