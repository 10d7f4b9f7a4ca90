#include "hypgen/search/planner.hpp"

#include <algorithm>
#include <cmath>

#include "hypgen/model/model.hpp"

namespace hypgen {

namespace {

// Of the memory: the evaluator keeps states and rows, the tree everything else. They share it as an expansion
// takes it: two groups an action, of which a search looks at two, or with regularisation at all; on the host
// a fifth of the scenarios (RockSample(7,8) fills both at about the same time).
std::size_t evaluator_bytes(const PlannerOptions& options, int action_count) {
  constexpr std::size_t kGroups = 2, kLookedAt = 2, kMemberBytes = 10;
  const bool is_regularised = options.pruning > 0.0;
  const auto actions = static_cast<std::size_t>(action_count);
  const std::size_t tables = is_regularised ? actions : std::min(actions, kLookedAt);
  const std::size_t arrays = is_regularised || options.mode == Mode::kPomcp ? 2 : 1;
  const std::size_t tree = Expansion::bytes(actions, arrays) + sizeof(Node) +
                           tables * (sizeof(ActionTable) + kGroups * sizeof(Child));
  const std::size_t rows = actions * (sizeof(ActionRow) + kGroups * sizeof(ChildRow));
  const std::size_t members = wants_gpu(options.mode) ? 0 : options.scenarios / 5 * kMemberBytes;
  const std::size_t evaluator = rows + members;
  return options.memory_bytes / (evaluator + tree) * evaluator;
}

// The first look at what a rollout costs, where time is limited.
constexpr std::size_t kProbeScenarios = 4;

Clock::time_point deadline_after(double seconds) {
  const Clock::time_point now = Clock::now();
  if (!(seconds < 1e9)) return Clock::time_point::max();
  return now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

EvaluatorOptions evaluator_options(const PlannerOptions& options, const ModelDescriptor& model) {
  return {options.scenarios,
          evaluator_bytes(options, model.action_count),
          model.discount,
          options.depth,
          options.in_flight,
          options.device_memory_bytes,
          0,
          options.threads,
          options.patience};
}

namespace {

TreeOptions tree_options(const PlannerOptions& options, const ModelDescriptor& model, std::size_t threads) {
  const bool is_pomcp = options.mode == Mode::kPomcp;
  return {options.memory_bytes - evaluator_bytes(options, model.action_count),
          options.depth,
          model.discount,
          is_pomcp ? 0.0 : options.pruning,
          std::min(options.threads, threads),
          is_pomcp || options.exploration > 0.0,
          is_pomcp};
}

}  // namespace

Planner::Planner(std::unique_ptr<LeafEvaluator> evaluator, const ModelDescriptor& model,
                 const PlannerOptions& options)
    : evaluator_(evaluator.release()),
      options_(options),
      horizon_(model.horizon),
      search_(options, tree_options(options, model, evaluator_->threads())),
      leaf_sizes_(options.scenarios + 1) {
  candidates_.reserve(static_cast<std::size_t>(model.action_count));
  actions_.reserve(static_cast<std::size_t>(model.action_count));
  root_actions_.reserve(static_cast<std::size_t>(model.action_count) + 1);
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
    plan_search(belief, key, decision);
    is_device_lost_ |= decision.status == Status::kDeviceLost;
  }
  decision.search_seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return decision;
}

void Planner::plan_search(const Belief& belief, StreamKey key, Decision& decision) {
  decision.late_threads = search_.park(setup_.deadline);
  if (decision.late_threads > 0) {
    decision.status = Status::kDeadline;
    return;
  }
  if (is_device_lost_) replace_evaluator();
  if (!evaluator_) {
    decision.status = Status::kDeviceLost;
    return;
  }
  const bool is_timed = setup_.deadline != Clock::time_point::max();
  const bool probes = is_timed && options_.mode != Mode::kPomcp;
  const std::size_t count = probes ? std::min(options_.scenarios, kProbeScenarios) : options_.scenarios;
  belief.sample(key, 0, count, scenarios_);
  const Clock::time_point sampled = Clock::now();
  evaluator_->attach(0);
  const RootResult root = evaluator_->begin_search(scenarios_, setup_);
  decision.status = root.status;
  sampled_ = count;
  note_rollouts(Clock::now() - sampled, count);
  if (root.status != Status::kOk) return;
  const double share = 1.0 / root.row.count;
  decision.lower = share * from_fixed_sum(root.row.lower_sum);
  decision.upper = share * from_fixed_sum(root.row.upper_sum);
  root_actions_.clear();
  if (options_.mode == Mode::kRollout) {
    plan_rollout(belief, key, decision, root);
  } else if (probes) {
    plan_anytime(belief, key, decision, root);
  } else {
    plan_tree(decision, root);
  }
}

// Later plans use another evaluator. The lost one's memory is given back first.
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

EvaluatorStats Planner::evaluator_stats() {
  search_.park(Clock::time_point::max());
  EvaluatorStats stats = past_stats_;
  if (evaluator_) stats.add(evaluator_->stats());
  return stats;
}

void Planner::plan_tree(Decision& decision, const RootResult& root) {
  search_.run(*evaluator_, root, setup_, root_actions_, decision);
  if (options_.signature && decision.late_threads == 0) decision.signature = search_.tree().signature(0);
  if (is_failure(decision.status)) return;
  decision.action = search_.best_action(root.default_action);
  if (decision.expansions == 0) return;
  decision.looked = Looked::kTree;
  decision.scenarios = options_.scenarios;
}

// Takes in how long so many rollouts took. Fewer than the evaluator has lanes take as long as that many.
void Planner::note_rollouts(Clock::duration time, std::size_t count) {
  const double filled = static_cast<double>(std::max(count, evaluator_->lanes()));
  rollout_seconds_ = std::chrono::duration<double>(time).count() / filled;
}

Status Planner::evaluate(const LeafRequest& request, LeafResult& result) {
  if (evaluator_->submit(0, {&request, 1}) != 1) return Status::kEvaluatorFailed;
  const Clock::time_point start = Clock::now();
  while (!evaluator_->poll(0, result)) {
    const Clock::time_point now = Clock::now();
    const bool is_late = now >= setup_.deadline;
    if (!is_late && std::chrono::duration<double>(now - start).count() <= options_.patience) continue;
    evaluator_->release();
    return is_late ? Status::kDeadline : Status::kEvaluatorFailed;
  }
  return result.status;
}

}  // namespace hypgen
