#include "hypgen/planner.hpp"

#include <algorithm>
#include <cmath>

#include "hypgen/model.hpp"

namespace hypgen {

namespace {

// Of the memory: the evaluator keeps states and child rows, the tree everything else.
constexpr std::size_t kEvaluatorShare = 2;

// Rollout mode's first look at what a rollout costs, where time is limited.
constexpr std::size_t kProbeScenarios = 16;

Clock::time_point deadline_after(double seconds) {
  const Clock::time_point now = Clock::now();
  if (!(seconds < 1e9)) return Clock::time_point::max();
  return now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

bool failed(Status status) {
  return status == Status::kModelNan || status == Status::kEvaluatorFailed ||
         status == Status::kCrossedBounds;
}

}  // namespace

EvaluatorOptions evaluator_options(const PlannerOptions& options, double discount) {
  return {options.scenarios, options.memory_bytes / kEvaluatorShare, discount, options.depth};
}

Planner::Planner(std::unique_ptr<LeafEvaluator> evaluator, const ModelDescriptor& model,
                 const PlannerOptions& options)
    : evaluator_(std::move(evaluator)),
      options_(options),
      horizon_(model.horizon),
      tree_({options.memory_bytes - options.memory_bytes / kEvaluatorShare, options.depth, model.discount,
             options.pruning}),
      leaf_sizes_(options.scenarios + 1) {
  candidates_.reserve(static_cast<std::size_t>(model.action_count));
  actions_.reserve(static_cast<std::size_t>(model.action_count));
}

void Planner::prepare(const Belief& belief) { belief.reserve(scenarios_, options_.scenarios); }

Decision Planner::plan(const Belief& belief, std::uint64_t run, int step) {
  const Clock::time_point start = Clock::now();
  const StreamKey key =
      derive(options_.seed, StreamKind::kPlan, plan_number(run, static_cast<std::uint64_t>(step)));
  const int left = horizon_ > 0 ? std::max(1, horizon_ - step) : std::numeric_limits<int>::max();
  setup_ = {key, std::min(options_.depth, left), left <= options_.depth, deadline_after(options_.time_limit)};
  Decision decision;
  decision.action = belief.default_action(key);
  if (decision.action < 0) {
    decision.status = Status::kNoLegalAction;
  } else if (options_.mode != Mode::kDefault) {
    const bool probes = options_.mode == Mode::kRollout && setup_.deadline != Clock::time_point::max();
    const std::size_t count = probes ? std::min(options_.scenarios, kProbeScenarios) : options_.scenarios;
    belief.sample(key, 0, count, scenarios_);
    const Clock::time_point sampled = Clock::now();
    const RootResult root = evaluator_->begin_search(scenarios_, setup_);
    decision.status = root.status;
    sampled_ = count;
    rollout_seconds_ =
        std::chrono::duration<double>(Clock::now() - sampled).count() / static_cast<double>(count);
    if (root.status == Status::kOk) {
      const double share = 1.0 / root.row.count;
      decision.lower = share * from_fixed_sum(root.row.lower_sum);
      decision.upper = share * from_fixed_sum(root.row.upper_sum);
      if (options_.mode == Mode::kDespot) {
        plan_despot(decision, root);
      } else {
        plan_rollout(belief, key, decision, root);
      }
    }
  }
  decision.search_seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return decision;
}

void Planner::plan_despot(Decision& decision, const RootResult& root) {
  if (!tree_.reset(root.row)) {
    decision.status = Status::kMemoryFull;
    return;
  }
  const bool crossed_at_root = tree_.crossed() > 0;
  Status status = expand(0, decision);
  if (status == Status::kOk) tree_.backup(0);
  while (status == Status::kOk) {
    if (tree_.bounds(0).gap() <= options_.gap) {
      status = Status::kConverged;
    } else if (decision.trials >= options_.trial_limit) {
      status = Status::kTrialLimit;
    } else if (setup_.deadline != Clock::time_point::max() && Clock::now() >= setup_.deadline) {
      status = Status::kDeadline;
    } else {
      status = run_trial(decision);
      ++decision.trials;
    }
  }
  decision.status = crossed_at_root && !failed(status) ? Status::kCrossedBounds : status;
  decision.lower = tree_.bounds(0).lower;
  decision.upper = tree_.bounds(0).upper;
  decision.nodes = tree_.size();
  decision.crossed = tree_.crossed();
  if (options_.signature) decision.signature = tree_.signature(0);
  if (!failed(status)) decision.action = best_root_action(root.default_action);
}

// One trial (Algorithm 2, EXPLORE): down to where the excess uncertainty is gone, then back up.
Status Planner::run_trial(Decision& decision) {
  std::uint32_t node = 0;
  Status status = Status::kOk;
  bool progress = false;
  while (true) {
    if (!tree_.node(node).expanded()) {
      status = expand(node, decision);
      if (status != Status::kOk) break;
      progress = true;
    }
    if (tree_.node(node).action_count == 0) break;
    const std::uint32_t entry = tree_.best_action(node);
    const std::uint32_t child = tree_.best_child(entry, options_.target_ratio);
    if (tree_.child(child).terminal || !(tree_.excess_uncertainty(child, options_.target_ratio) > 0.0)) {
      break;
    }
    const std::uint32_t next = tree_.visit(node, entry, child);
    if (next == kNoIndex) {
      status = Status::kMemoryFull;
      break;
    }
    const bool is_deepest = tree_.node(next).depth >= setup_.depth_limit;
    if (is_deepest || (options_.pruning > 0.0 && tree_.is_blocked(next))) {
      tree_.make_default(next);
      progress = true;
      break;
    }
    node = next;
  }
  tree_.backup(node);
  // A trial without effect means that all uncertainty left is rounding.
  return status == Status::kOk && !progress ? Status::kConverged : status;
}

Status Planner::expand(std::uint32_t node_index, Decision& decision) {
  const Node& node = tree_.node(node_index);
  const Child& child = tree_.child(node.child);
  LeafRequest request{node_index, kNoHandle, 0, child.first, child.count, node.depth, {}};
  if (node.parent != kNoIndex) {
    const ActionEntry& entry = tree_.action(node.parent_entry);
    request.parent = tree_.node(node.parent).handle;
    request.action = entry.action;
  }
  LeafResult leaf;
  const Status status = evaluate(request, leaf);
  if (status != Status::kOk) return status;
  if (!tree_.expand(node_index, leaf)) return Status::kMemoryFull;
  count_expansion(leaf, node.depth, decision);
  return Status::kOk;
}

Status Planner::evaluate(const LeafRequest& request, LeafResult& result) {
  if (evaluator_->submit({&request, 1}) != 1 || !evaluator_->poll(result)) return Status::kEvaluatorFailed;
  return result.status;
}

void Planner::count_expansion(const LeafResult& leaf, int depth, Decision& decision) {
  ++decision.expansions;
  ++leaf_sizes_[leaf.count];
  decision.leaf_scenarios += leaf.count;
  decision.simulations += std::uint64_t{leaf.count} * leaf.actions.size();
  decision.max_depth = std::max(decision.max_depth, depth);
}

// The best lower bound; the default policy's action if it is as good, or if following the policy is.
int Planner::best_root_action(int default_action) const {
  const Node& root = tree_.node(0);
  double best = tree_.default_value(0);
  int action = default_action;
  for (std::uint32_t i = 0; i < root.action_count; ++i) {
    const ActionEntry& entry = tree_.action(root.first_action + i);
    const bool better = entry.bounds.lower > best;
    if (better || (entry.bounds.lower == best && entry.action == default_action)) {
      best = entry.bounds.lower;
      action = entry.action;
    }
  }
  return action;
}

}  // namespace hypgen
