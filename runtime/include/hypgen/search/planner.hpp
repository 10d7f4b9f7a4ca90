// SPDX-License-Identifier: Apache-2.0
// The planner: chooses an action for a belief.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/model/descriptor.hpp"
#include "hypgen/search/decision.hpp"
#include "hypgen/search/search.hpp"

namespace hypgen {

// Only the constructor, `prepare` and the fallback allocate. `plan` works within the memory of the options.
class Planner {
 public:
  Planner(std::unique_ptr<LeafEvaluator> evaluator, const ModelDescriptor& model,
          const PlannerOptions& options);

  // Makes another evaluator after one has lost its device by the problem named; may give null.
  using Fallback = std::function<std::unique_ptr<LeafEvaluator>(const std::string& problem)>;

  // The default policy acts while there is no evaluator.
  void set_fallback(Fallback fallback) { fallback_ = std::move(fallback); }

  // Lays out the scenarios' memory for beliefs of this kind, and lets the search's threads share the updates of
  // this one, which come between plans. The caller does so before the first plan. The planner has to outlive
  // the belief's last update.
  void prepare(Belief& belief);

  // Gives later plans so many seconds each.
  void set_time_limit(double seconds) { options_.time_limit = seconds; }

  // Ends the plan that another thread has under way, if any, as its deadline would. From any thread.
  void cancel() { is_cancelled_.store(true, std::memory_order_relaxed); }

  // Decides at time `step` of episode `run`. Gives a legal action unless the status is kNoLegalAction.
  Decision plan(const Belief& belief, std::uint64_t run, int step);

  // The sizes of the leaves expanded in all plans: entry n counts leaves with n scenarios. Waits for threads
  // that the last plan left behind.
  std::vector<std::uint64_t> leaf_sizes();

  // The number of threads that search. The system or the evaluator's memory may give fewer than asked for.
  std::size_t threads() const {
    return evaluator_ ? std::min(search_.threads(), evaluator_->threads()) : search_.threads();
  }

  // The root's actions in the tree that the last plan decided by. Waits for threads that it left behind.
  std::vector<RootAction> root_actions();

  // The actions that rollouts of the last plan compared to the last; none where `compared_actions` is 0.
  std::vector<ComparedAction> compared() const;

  // The tree of the last plan.
  const Tree& tree() const { return search_.tree(); }
  // The same once threads have ended that the last plan left behind.
  const Tree& tree_at_rest();
  // The scenarios of that tree, and the key of their draws.
  const ScenarioBuffer& scenarios() const { return scenarios_; }
  StreamKey search_key() const { return setup_.key; }

  // The counts of all evaluators so far. Waits for threads that the last plan left behind.
  EvaluatorStats evaluator_stats();

 private:
  // An action's gains over the default policy's action, in rollout mode.
  struct Candidate {
    int action = 0;
    std::uint64_t samples = 0;
    double gain = 0.0;         // sum
    double gain_square = 0.0;  // sum
    // Pairs of scenarios of a batch, and those of them that a step leaves in one group.
    double pairs = 0.0;
    double pairs_together = 0.0;
    double mean() const { return samples ? gain / static_cast<double>(samples) : 0.0; }
    double variance() const;
    double standard_error() const;
    // The groups that a step leaves of so many scenarios, as a share of them. No matter how many were sampled.
    double parted_share(std::size_t scenarios) const;
  };

  // What a comparison of actions is done with.
  struct ComparisonGoal {
    std::size_t survivors;  // at the most, if there is time for all rounds
    std::uint64_t samples;  // of each of them
  };

  // Deletes an evaluator. One that would wait for its device for ever stays in memory.
  struct DeleteUnlessStuck {
    void operator()(LeafEvaluator* evaluator) const {
      if (!evaluator->is_stuck()) delete evaluator;
    }
  };

  void plan_search(const Belief& belief, StreamKey key, Decision& decision);
  void replace_evaluator();
  void plan_tree(Decision& decision, const RootResult& root);
  void plan_pomcp(const Belief& belief, StreamKey key, Decision& decision, const RootResult& root);
  void plan_rollout(const Belief& belief, StreamKey key, Decision& decision, const RootResult& root);
  void plan_anytime(const Belief& belief, StreamKey key, Decision& decision, const RootResult& root);
  double chosen_pruning() const;
  std::size_t affordable_scenarios(std::size_t rolled) const;
  void keep_survivors(int default_action);
  void compare_actions(const Belief& belief, StreamKey key, Clock::time_point end, const ComparisonGoal& goal,
                       Decision& decision);
  int compared_action(int default_action) const;
  int improved_action(int default_action) const;
  Status evaluate(std::size_t thread, const LeafRequest& request, LeafResult& result);
  bool sample_gains(const Belief& belief, StreamKey key, Clock::time_point end, Decision& decision);
  std::size_t batch_until(Clock::time_point end) const;
  void note_rollouts(Clock::duration time, std::size_t count);
  std::size_t comparing_threads(std::size_t actions) const;
  void compare_slice(std::size_t slice);
  std::size_t take_gains(Decision& decision);
  void halve();
  const Candidate& best_candidate() const;

  std::unique_ptr<LeafEvaluator, DeleteUnlessStuck> evaluator_;  // null: lost
  Fallback fallback_;
  EvaluatorStats past_stats_;  // of evaluators that were lost
  bool is_device_lost_ = false;
  PlannerOptions options_;
  int horizon_;
  ScenarioBuffer scenarios_;
  SearchSetup setup_{};
  std::atomic<bool> is_cancelled_{false};  // the plan under way; relaxed, as nothing else goes with it
  std::vector<std::uint64_t> leaf_sizes_;  // of rollout mode
  std::vector<Candidate> candidates_;      // by ascending action
  std::vector<int> actions_;               // of the candidates
  std::vector<int> all_actions_;           // of the model
  LeafRequest compared_;                   // the root's expansion of which threads have slices
  std::vector<LeafResult> slices_;         // by thread
  const Workers::Job compare_slice_ = [this](std::size_t slice) { compare_slice(slice); };
  std::vector<int> root_actions_;  // that the tree starts with; empty: all
  std::uint64_t sampled_ = 0;      // scenarios that comparing actions has used
  double rollout_seconds_ = 0.0;   // time of one rollout in the last batch, on a full evaluator
  Search search_;                  // last: its threads use all of the above
};

// What an update of the belief has left of a period, in seconds: too little to search, where it took all of it.
inline double rest_of_period(double period, double update_seconds) {
  constexpr double kLeast = 1e-6;
  return std::max(kLeast, period - update_seconds);
}

// The options of a planner's evaluator.
EvaluatorOptions evaluator_options(const PlannerOptions& options, const ModelDescriptor& model);

}  // namespace hypgen
