// SPDX-License-Identifier: Apache-2.0
// Rollout mode: one-ply returns, sequential halving (Karnin, Koren and Somekh, ICML 2013) over the actions.

#include <algorithm>
#include <cmath>

#include "hypgen/model/model.hpp"
#include "hypgen/search/planner.hpp"

namespace hypgen {

namespace {

double pairs_of(std::uint32_t count) { return 0.5 * count * (count - 1.0); }

}  // namespace

double Planner::Candidate::variance() const {
  if (samples < 2) return 0.0;
  constexpr double kRounding = 1e-12;  // of the difference of two near squares, as a share of them
  const double square = gain_square / static_cast<double>(samples), variance = square - mean() * mean();
  return variance > kRounding * square ? variance : 0.0;
}

double Planner::Candidate::parted_share(std::size_t scenarios) const {
  // One pair more that stays together: few pairs are no proof that scenarios part.
  const double together = (pairs_together + 1.0) / (pairs + 1.0);
  return 1.0 / (1.0 + together * static_cast<double>(scenarios - 1));
}

double Planner::Candidate::standard_error() const {
  return samples < 2 ? 0.0 : std::sqrt(variance() / (static_cast<double>(samples) - 1.0));
}

void Planner::plan_rollout(const Belief& belief, StreamKey key, Decision& decision, const RootResult& root) {
  compare_actions(belief, key, setup_.deadline.time(), {1, UINT64_MAX}, decision);
  if (decision.status == Status::kOk) {
    decision.status = decision.trials >= options_.trial_limit ? Status::kTrialLimit : Status::kDeadline;
  }
  decision.nodes = decision.expansions;
  if (decision.status != Status::kModelNan) decision.action = compared_action(root.default_action);
}

// Samples the actions' gains until `end` or the goal, on common random numbers. Each round keeps the better half,
// as long as more than the survivors are left; the rounds share the time, the samples or the trials equally.
void Planner::compare_actions(const Belief& belief, StreamKey key, Clock::time_point end,
                              const ComparisonGoal& goal, Decision& decision) {
  candidates_.clear();
  actions_.clear();
  const Clock::time_point start = Clock::now();
  const bool timed = end != Clock::time_point::max();
  const Clock::duration whole = end - start;
  bool going = sample_gains(belief, key, timed ? start + whole / 8 : end, decision);
  const double most = static_cast<double>(candidates_.size() + 1) / static_cast<double>(goal.survivors);
  const int rounds = std::max(1, static_cast<int>(std::ceil(std::log2(most))));
  for (int round = 1; round <= rounds && going; ++round) {
    const double share = static_cast<double>(round) / rounds;
    const auto time = std::chrono::duration_cast<Clock::duration>(whole * share);
    const Clock::time_point round_end = timed ? start + time : end;
    const auto trials = static_cast<double>(options_.trial_limit) * share;
    const double samples = static_cast<double>(goal.samples) * share;
    while (going && static_cast<double>(decision.trials) < trials && Clock::now() < round_end &&
           static_cast<double>(candidates_[0].samples) < samples) {
      going = sample_gains(belief, key, round_end, decision);
    }
    if (going && round < rounds && candidates_.size() > goal.survivors) halve();
  }
}

// The best of the compared actions, if its gain is larger than chance makes it; otherwise the default's.
int Planner::compared_action(int default_action) const {
  if (candidates_.empty()) return default_action;
  const Candidate& best = best_candidate();
  const bool significant = best.gain > 0.0 && best.mean() > options_.gain_errors * best.standard_error();
  return significant ? best.action : default_action;
}

// The scenarios of the next batch: about two such batches fit before `end`.
std::size_t Planner::batch_until(Clock::time_point end) const {
  if (!setup_.deadline.is_limited()) return options_.scenarios;
  const double seconds = std::chrono::duration<double>(end - Clock::now()).count();
  const std::size_t actions = candidates_.empty() ? candidates_.capacity() : candidates_.size();
  const auto threads = static_cast<double>(comparing_threads(actions));
  const double fits = 0.5 * seconds * threads / (rollout_seconds_ * static_cast<double>(actions));
  return static_cast<std::size_t>(std::clamp(fits, 1.0, static_cast<double>(options_.scenarios)));
}

// The threads that compare so many actions, each its slice of them. A device runs them all at once.
std::size_t Planner::comparing_threads(std::size_t actions) const {
  return evaluator_->lanes() > 1 ? 1 : std::min(threads(), actions);
}

// Expands the root once over new scenarios, and adds up the gains. Without a time limit the first expansion
// takes the scenarios of the root.
bool Planner::sample_gains(const Belief& belief, StreamKey key, Clock::time_point end, Decision& decision) {
  const std::size_t batch = batch_until(end);
  const Clock::time_point start = Clock::now();
  if (decision.trials > 0 || sampled_ != batch) {
    belief.sample(key, static_cast<std::uint32_t>(sampled_), batch, scenarios_);
    decision.status = evaluator_->begin_search(scenarios_, setup_).status;
    if (decision.status != Status::kOk) return false;
    sampled_ += batch;
  }
  compared_ = {};
  compared_.count = static_cast<std::uint32_t>(batch);
  compared_.actions = candidates_.empty() ? all_actions_ : actions_;
  slices_.resize(comparing_threads(compared_.actions.size()));
  decision.late_threads = search_.share_until(slices_.size(), compare_slice_, setup_.deadline.time());
  if (decision.late_threads > 0) {
    decision.status = Status::kDeadline;
    return false;
  }
  for (const LeafResult& slice : slices_) {
    if (decision.status == Status::kOk) decision.status = slice.status;
  }
  if (decision.status != Status::kOk) {
    evaluator_->release();
    return false;
  }
  const std::size_t actions = take_gains(decision);
  decision.compared_actions = std::max(decision.compared_actions, actions);
  ++decision.trials;
  ++decision.expansions;
  decision.leaf_scenarios += batch;
  decision.simulations += batch * actions;
  ++leaf_sizes_[batch];
  note_rollouts(slices_.size() * (Clock::now() - start), batch * (actions + slices_.size()));
  return true;
}

// One thread's part of an expansion of the root. All threads have the same scenarios.
void Planner::compare_slice(std::size_t slice) {
  const std::size_t actions = compared_.actions.size(), slices = slices_.size();
  const std::size_t first = actions * slice / slices, end = actions * (slice + 1) / slices;
  LeafRequest request = compared_;
  request.actions = {compared_.actions.begin() + first, end - first};
  evaluator_->attach(slice);
  slices_[slice].status = evaluate(slice, request, slices_[slice]);
}

// Adds what all slices have found; gives the number of legal actions.
std::size_t Planner::take_gains(Decision& decision) {
  decision.looked = Looked::kOneStep;
  const bool is_first = candidates_.empty();
  std::size_t next = 0;  // all scenarios have the same legal actions
  for (const LeafResult& slice : slices_) {
    decision.children += slice.children.size();
    for (std::size_t i = 0; i < slice.actions.size(); ++i, ++next) {
      if (is_first) {
        candidates_.emplace_back().action = slice.actions[i].action;
        actions_.push_back(slice.actions[i].action);
      }
      Candidate& candidate = candidates_[next];
      candidate.samples += slice.count;
      candidate.gain += search_.tree().number(slice.gains[i].sum);
      candidate.gain_square += slice.gains[i].square_sum;
      const ActionRow& row = slice.actions[i];
      candidate.pairs += pairs_of(slice.count);
      for (std::uint32_t child = 0; child < row.child_count; ++child)
        candidate.pairs_together += pairs_of(slice.children[row.first_child + child].count);
    }
  }
  return next;
}

// Keeps the better half of the candidates; ties go to the lower action.
void Planner::halve() {
  std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
    return a.mean() != b.mean() ? a.mean() > b.mean() : a.action < b.action;
  });
  candidates_.resize((candidates_.size() + 1) / 2);
  std::sort(candidates_.begin(), candidates_.end(),
            [](const Candidate& a, const Candidate& b) { return a.action < b.action; });
  actions_.clear();
  for (const Candidate& candidate : candidates_) actions_.push_back(candidate.action);
}

std::vector<ComparedAction> Planner::compared() const {
  std::vector<ComparedAction> found;
  for (const Candidate& one : candidates_)
    found.push_back({one.action, one.mean(), one.standard_error(), one.samples});
  return found;
}

const Planner::Candidate& Planner::best_candidate() const {
  return *std::max_element(candidates_.begin(), candidates_.end(),
                           [](const Candidate& a, const Candidate& b) { return a.mean() < b.mean(); });
}

}  // namespace hypgen
