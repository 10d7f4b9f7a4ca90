// Expands leaves on the host, one at a time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "hypgen/arena.hpp"
#include "hypgen/grouping.hpp"
#include "hypgen/leaf_evaluator.hpp"
#include "hypgen/model.hpp"
#include "hypgen/rollout.hpp"

namespace hypgen {

// Keeps, of each expanded leaf, its history and its scenarios' numbers and states. A child's members are
// found again by simulating one action over its parent's.
template <class M>
class CpuEvaluator final : public LeafEvaluator {
 public:
  CpuEvaluator(const typename M::Params& params, const EvaluatorOptions& options)
      : params_(params),
        options_(options),
        fixed_(options.max_scenarios),
        states_(options.max_scenarios),
        members_(options.max_scenarios),
        baseline_(options.max_scenarios),
        outcomes_(std::max<std::size_t>(
            options.max_scenarios,
            std::min(options.max_scenarios * M::kActionCount, kOutcomeBytes / kBytesAnOutcome))),
        grouping_(options.max_scenarios),
        cache_(options.max_scenarios, options.max_depth),
        rollout_(params_, cache_, options.discount, options.max_depth),
        nodes_(options.memory_bytes / 5 * 2 / (sizeof(Node) + sizeof(Member) + kHistoryBytes) + 1),
        kept_(nodes_.capacity() + options.max_scenarios),
        histories_(M::kHasHistory ? nodes_.capacity() : 1),
        child_rows_(options.memory_bytes / 5 * 3 / sizeof(ChildRow) +
                    M::kActionCount * options.max_scenarios) {
    queue_.reserve(options.in_flight);
    legal_.reserve(M::kActionCount);
    action_rows_.reserve(M::kActionCount);
    gains_.reserve(M::kActionCount);
    if (M::kHasHistory) {
      after_.reserve(outcomes_.size());
      after_of_.resize(outcomes_.size());
    }
  }

  RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) override {
    release();
    setup_ = setup;
    past_steps_ += steps_ + rollout_.steps();
    cache_.begin_search(setup.key, root.first());
    rollout_.begin_search(setup);
    steps_ = next_check_ = 0;
    const std::size_t count = root.size();
    if (count == 0 || count > fixed_.size() || setup.depth_limit > options_.max_depth ||
        !root.holds(sizeof(typename M::Fixed), sizeof(typename M::State), sizeof history_)) {
      return {Status::kEvaluatorFailed, {}, -1};
    }
    root.copy_to(fixed_.data(), states_.data());
    root.copy_history_to(history_);
    for (std::uint32_t i = 0; i < count; ++i) members_[i] = {i, states_[i]};
    keep(count);
    return bound_root(count);
  }

  std::size_t submit(Span<const LeafRequest> requests) override {
    const std::size_t count = std::min(requests.size(), options_.in_flight - queue_.size());
    queue_.insert(queue_.end(), requests.begin(), requests.begin() + count);
    return count;
  }

  bool poll(LeafResult& result) override {
    if (queue_.empty()) return false;
    const LeafRequest request = queue_.front();
    queue_.erase(queue_.begin());
    result = {request.ticket, Status::kOk, 0, request.count, {}, {}, {}};
    const std::uint32_t first_row = child_rows_.size();
    result.status = expand(request, result.handle);
    if (result.status == Status::kOk) {
      ++leaves_;
      result.actions = action_rows_;
      result.children = {&child_rows_[first_row], child_rows_.size() - first_row};
      result.gains = gains_;
    }
    return true;
  }

  void release() override {
    queue_.clear();
    nodes_.reset();
    kept_.reset();
    histories_.reset();
    child_rows_.reset();
  }

  EvaluatorStats stats() const override {
    EvaluatorStats stats;
    stats.leaves = leaves_;
    stats.steps = past_steps_ + steps_ + rollout_.steps();
    return stats;
  }

 private:
  // Of the outcomes held at once: more actions than fit are simulated in blocks.
  static constexpr std::size_t kOutcomeBytes = std::size_t{20} << 20;
  static constexpr std::uint64_t kStepsBetweenChecks = 2048;  // of the clock: tens of microseconds

  static constexpr std::size_t kHistoryBytes = M::kHasHistory ? sizeof(typename M::History) : 0;

  struct Member {
    std::uint32_t scenario;  // index into fixed_
    typename M::State state;
  };
  struct Node {
    std::uint32_t first;  // of its members in kept_
    std::uint32_t count;
  };
  struct Outcome {
    std::int64_t reward;
    typename M::Key key;
    ScenarioBounds bounds;
    bool terminal;
  };
  static constexpr std::size_t kBytesAnOutcome =
      sizeof(Outcome) + (M::kHasHistory ? kHistoryBytes + sizeof(std::uint32_t) : 0);

  SearchDraws draws(std::uint32_t scenario, int depth) {
    return SearchDraws(cache_, scenario, static_cast<std::uint32_t>(depth));
  }

  RootResult bound_root(std::size_t count) {
    PhiloxDraws first(cache_.key(), 0, 0);
    RootResult result{Status::kOk, empty_row(0, static_cast<std::uint32_t>(count), false), -1};
    result.default_action = M::default_policy(params_, fixed_[0], states_[0], history_, first);
    for (std::uint32_t i = 0; i < count; ++i) {
      const ScenarioBounds bounds = rollout_.bounds(fixed_[i], states_[i], history_, i, 0);
      result.row.upper_sum += bounds.upper;
      result.row.lower_sum += bounds.lower;
      if (out_of_time()) result.status = Status::kDeadline;
      if (result.status != Status::kOk) break;
    }
    if (rollout_.met_nan()) result.status = Status::kModelNan;
    return result;
  }

  Status expand(const LeafRequest& request, std::uint64_t& handle) {
    const bool is_root = request.parent == kNoHandle;
    const std::size_t count = is_root ? load(0) : find_members(request);
    if (count == 0 || count != request.count) return Status::kEvaluatorFailed;
    handle = is_root ? 0 : keep(count);
    if (handle == kNoHandle) return Status::kMemoryFull;
    list_legal(request.actions);
    action_rows_.clear();
    gains_.clear();
    if (is_root && !set_baseline(count)) return Status::kDeadline;
    const std::size_t block = std::max<std::size_t>(1, outcomes_.size() / count);
    for (std::size_t first = 0; first < legal_.size(); first += block) {
      const Span<const int> actions(legal_.data() + first, std::min(block, legal_.size() - first));
      if (!simulate(actions, count, request.depth)) return Status::kDeadline;
      for (std::size_t a = 0; a < actions.size(); ++a) {
        const Outcome* outcomes = outcomes_.data() + a * count;
        if (!reduce(actions[a], outcomes, count)) return Status::kMemoryFull;
        if (is_root) add_gain(outcomes, count);
      }
    }
    return rollout_.met_nan() ? Status::kModelNan : Status::kOk;
  }

  std::size_t load(std::uint64_t handle) {
    const Node node = nodes_[handle];
    if (M::kHasHistory) history_ = histories_[handle];
    std::copy_n(&kept_[node.first], node.count, members_.begin());
    return node.count;
  }

  // Simulates the request's action over the parent's members and takes those that see what member `first`
  // sees, and its history.
  [[gnu::noinline]] std::size_t find_members(const LeafRequest& request) {
    const Node parent = nodes_[request.parent];
    typename M::Key wanted{};
    std::size_t count = 0;
    for (std::uint32_t i = request.first; i < parent.count && count < request.count; ++i) {
      const Member& from = kept_[parent.first + i];
      const typename M::Fixed& fixed = fixed_[from.scenario];
      SearchDraws words = draws(from.scenario, request.depth - 1);
      typename M::State next;
      ++steps_;
      if (M::step(params_, fixed, from.state, request.action, words, next).terminal) {
        if (count == 0) return 0;
        continue;
      }
      const typename M::Key key = M::observe(params_, fixed, from.state, request.action, words, next);
      if (count == 0) {
        wanted = key;
        if (M::kHasHistory) {
          M::advance_history(params_, fixed, from.state, request.action, key, next,
                             histories_[request.parent], history_);
        }
      }
      if (key == wanted) members_[count++] = {from.scenario, next};
    }
    return count;
  }

  // Stores the first `count` of members_ and gives their handle, or kNoHandle if there is no room.
  std::uint64_t keep(std::size_t count) {
    if (!nodes_.fits(1) || !kept_.fits(count)) return kNoHandle;
    const std::uint32_t first = kept_.allocate(count);
    std::copy_n(members_.begin(), count, &kept_[first]);
    const std::uint32_t node = nodes_.allocate(1);
    nodes_[node] = {first, static_cast<std::uint32_t>(count)};
    if (M::kHasHistory) histories_[histories_.allocate(1)] = history_;
    return node;
  }

  // Legality reads visible variables only, and those are equal in all members.
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

  // Fills outcomes_, action by action; false if the deadline has passed. Not inlined, nor is find_members: in
  // one function with all else the rollout's loop loses its registers, and a fifth of its speed.
  [[gnu::noinline]] bool simulate(Span<const int> actions, std::size_t count, int depth) {
    if (M::kHasHistory && !make_histories(actions, count, depth)) return false;
    for (std::size_t i = 0; i < count; ++i) {
      const Member member = members_[i];
      const typename M::Fixed& fixed = fixed_[member.scenario];
      SearchDraws words = draws(member.scenario, depth);
      memo_.clear();
      for (std::size_t a = 0; a < actions.size(); ++a) {
        Outcome& outcome = outcomes_[a * count + i];
        typename M::State next;
        const StepResult step = M::step(params_, fixed, member.state, actions[a], words, next);
        rollout_.note_error(step.error);
        outcome = {step.reward, {}, {0, 0}, step.terminal};
        if (step.terminal) continue;
        outcome.key = M::observe(params_, fixed, member.state, actions[a], words, next);
        const typename M::History& after = M::kHasHistory ? after_[after_of_[a * count + i]] : history_;
        outcome.bounds = memo_.find_or(
            next, after, [&] { return rollout_.bounds(fixed, next, after, member.scenario, depth + 1); });
      }
      steps_ += actions.size();
      if (out_of_time()) return false;
    }
    return true;
  }

  // Fills after_, with one history for each group of each action, and after_of_; false if the deadline has
  // passed.
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
        if (M::step(params_, fixed, member.state, actions[a], words, next).terminal) continue;
        const typename M::Key key = M::observe(params_, fixed, member.state, actions[a], words, next);
        const std::size_t group = first + grouping_.number(false, key);
        if (group == after_.size()) {
          after_.emplace_back();
          M::advance_history(params_, fixed, member.state, actions[a], key, next, history_, after_.back());
        }
        after_of_[a * count + i] = static_cast<std::uint32_t>(group);
      }
      steps_ += count;
      if (out_of_time()) return false;
    }
    return true;
  }

  // The default action's one-ply returns, which gains at the root are measured against.
  bool set_baseline(std::size_t count) {
    PhiloxDraws first(cache_.key(), 0, 0);
    const int action = M::default_policy(params_, fixed_[0], members_[0].state, history_, first);
    std::fill_n(baseline_.begin(), count, 0);
    if (action < 0) return true;
    if (!simulate({&action, 1}, count, 0)) return false;
    for (std::size_t i = 0; i < count; ++i) baseline_[i] = one_ply_return(outcomes_[i]);
    return true;
  }

  std::int64_t one_ply_return(const Outcome& outcome) const {
    return outcome.reward +
           static_cast<std::int64_t>(options_.discount * static_cast<double>(outcome.bounds.lower));
  }

  // Sums an action's outcomes by group; false if there is no room for its groups.
  bool reduce(int action, const Outcome* outcomes, std::size_t count) {
    const std::uint32_t first = child_rows_.size();
    ActionRow row{0, 0, 0, action, action_rows_.empty() ? 0 : next_child(action_rows_.back()), 0, 0};
    grouping_.clear();
    for (std::size_t i = 0; i < count; ++i) {
      const Outcome& outcome = outcomes[i];
      const std::uint32_t group = grouping_.number(outcome.terminal, outcome.key);
      if (group == row.child_count) {
        if (child_rows_.allocate(1) == Arena<ChildRow>::kFull) return false;
        ++row.child_count;
        child_rows_[first + group] = empty_row(static_cast<std::uint32_t>(i), 0, outcome.terminal);
      }
      ChildRow& child = child_rows_[first + group];
      ++child.count;
      child.upper_sum += outcome.bounds.upper;
      child.lower_sum += outcome.bounds.lower;
      row.reward_sum += outcome.reward;
    }
    for (std::uint32_t i = 0; i < row.child_count; ++i) {
      const ChildRow& child = child_rows_[first + i];
      row.upper_sum += std::max(child.upper_sum, child.lower_sum);
      row.lower_sum += child.lower_sum;
    }
    action_rows_.push_back(row);
    return true;
  }

  static std::uint32_t next_child(const ActionRow& row) { return row.first_child + row.child_count; }

  // Compares an action with the default policy's.
  void add_gain(const Outcome* outcomes, std::size_t count) {
    Gain total{0, 0.0};
    for (std::size_t i = 0; i < count; ++i) {
      const std::int64_t gain = one_ply_return(outcomes[i]) - baseline_[i];
      total.sum += gain;
      total.square_sum += from_fixed_sum(gain) * from_fixed_sum(gain);
    }
    gains_.push_back(total);
  }

  // Looks at the clock now and then.
  bool out_of_time() {
    if (steps_ + rollout_.steps() < next_check_) return false;
    next_check_ = steps_ + rollout_.steps() + kStepsBetweenChecks;
    return setup_.deadline != Clock::time_point::max() && Clock::now() >= setup_.deadline;
  }

  const typename M::Params& params_;
  EvaluatorOptions options_;
  SearchSetup setup_{};
  std::uint64_t leaves_ = 0;      // since it was made
  std::uint64_t past_steps_ = 0;  // of earlier searches
  std::uint64_t steps_ = 0;       // of this search, without those of rollouts
  std::uint64_t next_check_ = 0;
  std::vector<typename M::Fixed> fixed_;    // of the root's scenarios
  std::vector<typename M::State> states_;   // theirs at the root
  std::vector<Member> members_;             // of the leaf in work
  typename M::History history_{};           // of the leaf in work
  std::vector<typename M::History> after_;  // of the groups of its actions
  std::vector<std::uint32_t> after_of_;     // of each outcome: into after_
  std::vector<std::int64_t> baseline_;
  std::vector<Outcome> outcomes_;
  std::vector<int> legal_;
  std::vector<LeafRequest> queue_;
  std::vector<ActionRow> action_rows_;
  std::vector<Gain> gains_;
  ActionGrouping<typename M::Key> grouping_;
  DrawCache cache_;
  Rollout<M> rollout_;
  BoundsMemo<M> memo_;
  Arena<Node> nodes_;
  Arena<Member> kept_;
  Arena<typename M::History> histories_;  // of nodes_
  Arena<ChildRow> child_rows_;            // of all leaves of the search
};

}  // namespace hypgen
