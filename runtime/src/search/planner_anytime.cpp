// SPDX-License-Identifier: Apache-2.0
// A tree search that has an answer at any time: first one-ply rollouts of all actions, then a tree over those
// that survive, on as many scenarios as the time affords.

#include <algorithm>
#include <cmath>

#include "hypgen/model/model.hpp"
#include "hypgen/search/planner.hpp"

namespace hypgen {

namespace {

constexpr std::size_t kSurvivors = 16;  // actions that the tree starts with
constexpr int kComparedShare = 4;       // of the time goes to comparing, as one part of so many, at the most
constexpr std::uint64_t kComparedSamples = 4;  // an action, in scenarios of the largest tree, at the most
constexpr double kRootShare = 1.0 / 6.0;     // of the time that is left goes to the tree's root, at the most
constexpr std::size_t kLeastScenarios = 16;  // of a tree
// Scenarios part where a step leaves more groups than this share of them: forty scenarios a group, or fewer.
constexpr double kPartedShare = 1.0 / 40.0;
constexpr double kLeastGroups = 4.0;  // fewer tell hardly anything apart, however few the scenarios are

}  // namespace

// `root` is that of a few scenarios. The tree replaces the comparison's answer where it has looked further
// than one step.
void Planner::plan_anytime(const Belief& belief, StreamKey key, Decision& decision, const RootResult& root) {
  const Clock::time_point start = Clock::now();
  compare_actions(belief, key, start + (setup_.deadline.time() - start) / kComparedShare,
                  {kSurvivors, kComparedSamples * options_.scenarios}, decision);
  std::size_t count =
      affordable_scenarios(std::min({kSurvivors, candidates_.size(), std::size_t{options_.rolled_at_root}}));
  const auto has_trials = [&] { return decision.trials < options_.trial_limit; };
  while (decision.status == Status::kOk && count < kLeastScenarios && has_trials() &&
         !setup_.deadline.has_passed()) {
    sample_gains(belief, key, setup_.deadline.time(), decision);  // too dear for a tree
  }
  if (is_failure(decision.status) || decision.status == Status::kDeviceLost) return;
  decision.action = compared_action(root.default_action);
  if (decision.status != Status::kOk) return;
  keep_survivors(root.default_action);
  setup_.weighted = options_.observations == Observations::kWeighted;
  const double pruning = chosen_pruning();
  search_.set_pruning(pruning);
  while (count >= kLeastScenarios && !setup_.deadline.has_passed()) {
    belief.sample(key, 0, count, scenarios_);
    search_.clear();
    decision.keeps_tree = false;
    const RootResult next = evaluator_->begin_search(scenarios_, setup_);
    if (next.status != Status::kOk) break;
    Decision stage;
    search_.run(*evaluator_, next, setup_, root_actions_, stage);
    const bool has_looked_ahead = stage.expansions > 1 && !is_failure(stage.status);
    if (has_looked_ahead) {
      stage.action = improved_action(root.default_action);
      stage.looked = Looked::kTree;
      stage.keeps_tree = true;
      stage.scenarios = count;
      stage.pruning = pruning;
    } else {
      stage.take_answer(decision);
    }
    if (options_.signature && stage.late_threads == 0) stage.signature = search_.tree().signature(0);
    stage.add_work(decision);
    decision = stage;
    if (!has_looked_ahead || decision.status != Status::kConverged || count == options_.scenarios) return;
    count = std::min(2 * count, options_.scenarios);
  }
  if (decision.status == Status::kOk)
    decision.status = has_trials() ? Status::kDeadline : Status::kTrialLimit;
}

// Lambda for the tree after a comparison. A group of one scenario knows its future, and promises what no policy
// can earn: by chance up to about the deviation of a scenario's gain. So that deviation, as a share of one
// scenario, is what a node has to be worth. Where scenarios stay together there is little of that, and lambda
// is 0 (docs/decisions/0050).
double Planner::chosen_pruning() const {
  if (options_.pruning != kAutoPruning) return options_.pruning;
  if (setup_.weighted) return 0.0;  // its groups have several scenarios
  double variance = 0.0, parted = 0.0;
  for (const Candidate& candidate : candidates_) {
    variance = std::max(variance, candidate.variance());
    parted += candidate.parted_share(options_.scenarios);
  }
  const auto count = static_cast<double>(options_.scenarios);
  const double share = parted / std::max<double>(1.0, static_cast<double>(candidates_.size()));
  if (!(share > kPartedShare && share * count > kLeastGroups)) return 0.0;
  return std::sqrt(variance) / count;
}

// The best action by its gain in the comparison and what the tree has added to it. The tree's own one-ply returns
// are not used: the comparison has more scenarios, and its noise is known.
int Planner::improved_action(int default_action) const {
  const double own = search_.improvement(default_action);
  int action = default_action;
  double best = 0.0;
  for (const Candidate& candidate : candidates_) {
    if (candidate.action == default_action) continue;
    const double gain = candidate.mean() + search_.improvement(candidate.action) - own;
    if (gain <= options_.gain_errors * candidate.standard_error() || gain <= best) continue;
    best = gain;
    action = candidate.action;
  }
  return action;
}

// The compared actions that are left, with the default policy's; all actions where no more than those were
// legal.
void Planner::keep_survivors(int default_action) {
  root_actions_ = actions_;
  const auto place = std::lower_bound(root_actions_.begin(), root_actions_.end(), default_action);
  if (place == root_actions_.end() || *place != default_action) root_actions_.insert(place, default_action);
}

// How many scenarios a tree may have, so that its root takes a share of the time that is left: bounds of the
// root, and an expansion that rolls so many actions out, and the default policy's.
std::size_t Planner::affordable_scenarios(std::size_t rolled) const {
  const double seconds = std::chrono::duration<double>(setup_.deadline.time() - Clock::now()).count();
  const double count = kRootShare * seconds / (rollout_seconds_ * (static_cast<double>(rolled) + 2.0));
  return static_cast<std::size_t>(std::clamp(count, 0.0, static_cast<double>(options_.scenarios)));
}

}  // namespace hypgen
