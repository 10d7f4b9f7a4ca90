// SPDX-License-Identifier: Apache-2.0
#include "hypgen/search/planner.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "hypgen/lanes/choice.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen {

namespace {

// The first look at the time of a rollout takes so many scenarios, where time is limited.
constexpr std::size_t kProbeScenarios = 4;

Clock::time_point deadline_after(double seconds) {
  const Clock::time_point now = Clock::now();
  if (!(seconds < 1e9)) return Clock::time_point::max();
  return now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

// The evaluator's memory for an expansion in a typical tree: rows of two groups an action, and on the host the
// members of a fifth of the scenarios.
std::size_t evaluator_expansion_bytes(const PlannerOptions& options, std::size_t actions) {
  constexpr std::size_t kGroups = 2, kMemberBytes = 10;
  const std::size_t rows = actions * (sizeof(ActionRow) + kGroups * sizeof(ChildRow));
  return rows + (wants_gpu(options.mode) ? 0 : options.scenarios / 5 * kMemberBytes);
}

TreeOptions tree_options(const PlannerOptions& options, const ModelDescriptor& model, std::size_t threads) {
  const bool is_pomcp = options.mode == Mode::kPomcp;
  TreeOptions result;
  result.max_depth = options.depth;
  result.discount = model.discount;
  result.reward_bits = model.reward_bits;
  result.pruning = is_pomcp ? 0.0 : std::max(0.0, options.pruning);
  result.threads = std::min(options.threads, threads);
  result.counts_actions = is_pomcp || options.exploration > 0.0;
  result.keeps_values = is_pomcp;
  result.memory_bytes = options.memory_bytes - evaluator_options(options, model).memory_bytes;
  return result;
}

}  // namespace

// Tree and evaluator share the memory in proportion to what an expansion takes of each.
EvaluatorOptions evaluator_options(const PlannerOptions& options, const ModelDescriptor& model) {
  const auto actions = static_cast<std::size_t>(model.action_count);
  TreeOptions tree;
  tree.pruning = std::max(0.0, options.pruning);
  tree.keeps_values = options.mode == Mode::kPomcp;
  const std::size_t expansion = evaluator_expansion_bytes(options, actions);
  EvaluatorOptions result;
  result.max_scenarios = options.scenarios;
  result.memory_bytes = options.memory_bytes / (expansion + tree.expansion_bytes(actions)) * expansion;
  result.discount = model.discount;
  result.max_depth = options.depth;
  result.in_flight = options.in_flight;
  result.device_memory_bytes = options.device_memory_bytes;
  result.threads = options.threads;
  result.may_weigh = options.observations == Observations::kWeighted;
  result.patience = options.patience;
  result.lanes = options.lanes ? first_lanes(model.lanes) : nullptr;
  return result;
}

Planner::Planner(std::unique_ptr<LeafEvaluator> evaluator, const ModelDescriptor& model,
                 const PlannerOptions& options)
    : evaluator_(evaluator.release()),
      options_(options),
      horizon_(model.horizon),
      leaf_sizes_(options.scenarios + 1),
      search_(options, tree_options(options, model, evaluator_->threads())) {
  candidates_.reserve(static_cast<std::size_t>(model.action_count));
  actions_.reserve(static_cast<std::size_t>(model.action_count));
  all_actions_.resize(static_cast<std::size_t>(model.action_count));
  std::iota(all_actions_.begin(), all_actions_.end(), 0);
  slices_.reserve(search_.threads());
  root_actions_.reserve(static_cast<std::size_t>(model.action_count) + 1);
}

void Planner::prepare(Belief& belief) {
  belief.reserve(scenarios_, options_.scenarios);
  belief.use(search_.threads() > 1 ? &search_ : nullptr);
}

Decision Planner::plan(const Belief& belief, std::uint64_t run, int step) {
  const Clock::time_point start = Clock::now();
  const StreamKey key =
      derive(options_.seed, StreamKind::kPlan, plan_number(run, static_cast<std::uint64_t>(step)));
  const int left = horizon_ > 0 ? std::max(1, horizon_ - step) : std::numeric_limits<int>::max();
  setup_.key = key;
  setup_.depth_limit = std::min(options_.depth, left);
  setup_.at_horizon = left <= options_.depth;
  is_cancelled_.store(false, std::memory_order_relaxed);
  setup_.deadline = {deadline_after(options_.time_limit), &is_cancelled_};
  Decision decision;
  decision.action = belief.default_action(key);
  if (decision.action < 0) {
    decision.status = Status::kNoLegalAction;
  } else if (options_.mode != Mode::kDefault) {
    plan_search(belief, key, decision);
    is_device_lost_ |= decision.status == Status::kDeviceLost;
  }
  decision.search_seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return decision;
}

void Planner::plan_search(const Belief& belief, StreamKey key, Decision& decision) {
  decision.late_threads = search_.park(setup_.deadline.time());
  if (decision.late_threads > 0) {
    decision.status = Status::kDeadline;
    return;
  }
  if (is_device_lost_) replace_evaluator();
  if (!evaluator_) {
    decision.status = Status::kDeviceLost;
    return;
  }
  const bool is_timed = setup_.deadline.is_limited();
  const std::size_t count = is_timed ? std::min(options_.scenarios, kProbeScenarios) : options_.scenarios;
  setup_.weighted =
      options_.observations == Observations::kWeighted && !is_timed && options_.mode != Mode::kRollout;
  belief.sample(key, 0, count, scenarios_);
  const Clock::time_point sampled = Clock::now();
  search_.clear();
  evaluator_->attach(0);
  const RootResult root = evaluator_->begin_search(scenarios_, setup_);
  decision.status = root.status;
  sampled_ = count;
  note_rollouts(Clock::now() - sampled, count);
  if (root.status != Status::kOk) return;
  const double share = 1.0 / root.row.count;
  decision.lower = share * search_.tree().number(root.row.lower_sum);
  decision.upper = share * search_.tree().number(root.row.upper_sum);
  root_actions_.clear();
  if (options_.mode == Mode::kRollout) {
    plan_rollout(belief, key, decision, root);
  } else if (is_timed && options_.mode == Mode::kPomcp) {
    plan_pomcp(belief, key, decision, root);
  } else if (is_timed) {
    plan_anytime(belief, key, decision, root);
  } else {
    plan_tree(decision, root);
  }
}

// Gives back the lost evaluator's memory, and makes another evaluator for later plans.
void Planner::replace_evaluator() {
  past_stats_ = evaluator_stats();
  const std::string problem = evaluator_ ? evaluator_->problem() : "";
  evaluator_.reset();
  if (fallback_) evaluator_.reset(fallback_(problem).release());
  is_device_lost_ = !evaluator_;
}

std::vector<std::uint64_t> Planner::leaf_sizes() {
  std::vector<std::uint64_t> sum = leaf_sizes_;
  search_.add_leaf_sizes(sum);
  return sum;
}

std::vector<RootAction> Planner::root_actions() {
  search_.park(Clock::time_point::max());
  return search_.root_actions();
}

const Tree& Planner::tree_at_rest() {
  search_.park(Clock::time_point::max());
  return search_.tree();
}

EvaluatorStats Planner::evaluator_stats() {
  search_.park(Clock::time_point::max());
  EvaluatorStats stats = past_stats_;
  if (evaluator_) stats.add(evaluator_->stats());
  return stats;
}

void Planner::plan_tree(Decision& decision, const RootResult& root) {
  const double pruning = options_.mode == Mode::kPomcp ? 0.0 : std::max(0.0, options_.pruning);
  search_.set_pruning(pruning);
  search_.run(*evaluator_, root, setup_, root_actions_, decision);
  if (options_.signature && decision.late_threads == 0) decision.signature = search_.tree().signature(0);
  if (is_failure(decision.status)) return;
  decision.action = search_.best_action(root.default_action);
  if (decision.expansions == 0) return;
  decision.looked = Looked::kTree;
  decision.keeps_tree = true;
  decision.scenarios = scenarios_.size();
  decision.pruning = pruning;
}

// `root` is that of a few scenarios. The tree has as many as its root, whose actions are all rolled out, leaves time for.
void Planner::plan_pomcp(const Belief& belief, StreamKey key, Decision& decision, const RootResult& root) {
  const std::size_t count = std::max(scenarios_.size(), affordable_scenarios(all_actions_.size()));
  if (count == scenarios_.size()) return plan_tree(decision, root);
  belief.sample(key, 0, count, scenarios_);
  search_.clear();
  const RootResult next = evaluator_->begin_search(scenarios_, setup_);
  decision.status = next.status;
  if (next.status == Status::kOk) plan_tree(decision, next);
}

// Takes in how long so many rollouts took. Fewer than the evaluator has lanes take as long as that many.
void Planner::note_rollouts(Clock::duration time, std::size_t count) {
  const double filled = static_cast<double>(std::max(count, evaluator_->lanes()));
  rollout_seconds_ = std::chrono::duration<double>(time).count() / filled;
}

Status Planner::evaluate(std::size_t thread, const LeafRequest& request, LeafResult& result) {
  const Clock::time_point start = Clock::now();
  bool is_taken = false;
  while (true) {
    is_taken = is_taken || evaluator_->submit(thread, {&request, 1}) == 1;
    if (is_taken && evaluator_->poll(thread, result)) return result.status;
    const Clock::time_point now = Clock::now();
    const bool is_late = setup_.deadline.has_passed(now);
    if (!is_late && std::chrono::duration<double>(now - start).count() <= options_.patience) continue;
    return is_late ? Status::kDeadline : Status::kEvaluatorFailed;
  }
}

}  // namespace hypgen
