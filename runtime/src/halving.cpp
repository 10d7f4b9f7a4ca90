// Rollout mode: one-ply returns, sequential halving (Karnin, Koren and Somekh, ICML 2013) over the actions.

#include <algorithm>
#include <cmath>

#include "hypgen/model.hpp"
#include "hypgen/planner.hpp"

namespace hypgen {

double Planner::Candidate::standard_error() const {
  if (samples < 2) return 0.0;
  const double n = static_cast<double>(samples);
  return std::sqrt(std::max(0.0, gain_square / n - mean() * mean()) / (n - 1.0));
}

void Planner::plan_rollout(const Belief& belief, StreamKey key, Decision& decision, const RootResult& root) {
  candidates_.clear();
  actions_.clear();
  const Clock::time_point start = Clock::now();
  const bool timed = setup_.deadline != Clock::time_point::max();
  bool going = sample_gains(belief, key, decision);
  const int rounds = static_cast<int>(std::ceil(std::log2(static_cast<double>(candidates_.size() + 1))));
  for (int round = 1; round <= rounds && going; ++round) {
    const double share = static_cast<double>(round) / rounds;
    const auto time = std::chrono::duration_cast<Clock::duration>((setup_.deadline - start) * share);
    const auto trials = static_cast<double>(options_.trial_limit) * share;
    while (going && static_cast<double>(decision.trials) < trials &&
           (!timed || Clock::now() < start + time)) {
      going = sample_gains(belief, key, decision);
    }
    if (going && round < rounds) halve();
  }
  if (decision.status == Status::kOk) {
    decision.status = decision.trials >= options_.trial_limit ? Status::kTrialLimit : Status::kDeadline;
  }
  decision.nodes = decision.expansions;
  if (candidates_.empty() || decision.status == Status::kModelNan) return;
  const Candidate& best = best_candidate();
  const bool significant = best.gain > 0.0 && best.mean() > options_.gain_errors * best.standard_error();
  decision.action = significant ? best.action : root.default_action;
}

// One expansion of the root over scenarios that no earlier one has used.
bool Planner::sample_gains(const Belief& belief, StreamKey key, Decision& decision) {
  if (decision.trials > 0) {
    const auto first = static_cast<std::uint32_t>(decision.trials * options_.scenarios);
    belief.sample(key, first, options_.scenarios, scenarios_);
    decision.status = evaluator_->begin_search(scenarios_, setup_).status;
    if (decision.status != Status::kOk) return false;
  }
  LeafResult leaf;
  decision.status = evaluate({0, kNoHandle, 0, 0, 0, actions_}, leaf);
  if (decision.status != Status::kOk) return false;
  count_expansion(leaf, 0, decision);
  ++decision.trials;
  take_gains(leaf);
  return true;
}

void Planner::take_gains(const LeafResult& leaf) {
  if (candidates_.empty()) {
    for (const ActionRow& row : leaf.actions) {
      candidates_.push_back({row.action, 0, 0.0, 0.0});
      actions_.push_back(row.action);
    }
  }
  for (std::size_t i = 0; i < leaf.actions.size(); ++i) {
    const ActionRow& row = leaf.actions[i];  // of the candidate at the same place: legality does not change
    candidates_[i].samples += row.count;
    candidates_[i].gain += from_fixed_sum(row.gain_sum);
    candidates_[i].gain_square += row.gain_square_sum;
  }
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

const Planner::Candidate& Planner::best_candidate() const {
  return *std::max_element(candidates_.begin(), candidates_.end(),
                           [](const Candidate& a, const Candidate& b) { return a.mean() < b.mean(); });
}

}  // namespace hypgen
