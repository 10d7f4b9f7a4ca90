// Chooses actions by search.
#pragma once

#include <algorithm>
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

// Allocates only when it is made; `plan` works within the memory of its options.
class Planner {
 public:
  Planner(std::unique_ptr<LeafEvaluator> evaluator, const ModelDescriptor& model,
          const PlannerOptions& options);

  // Makes another evaluator once one has lost its device by the problem named; it may give null.
  using Fallback = std::function<std::unique_ptr<LeafEvaluator>(const std::string& problem)>;

  // Until there is another evaluator the default policy acts.
  void set_fallback(Fallback fallback) { fallback_ = std::move(fallback); }

  // The scenarios' memory is laid out for beliefs of this kind. To be called before the first plan.
  void prepare(const Belief& belief);

  // Decides at time `step` of episode `run`. Always gives a legal action, unless the status is
  // kNoLegalAction.
  Decision plan(const Belief& belief, std::uint64_t run, int step);

  // How many scenarios the leaves expanded so far had: entry n counts leaves with n.
  std::vector<std::uint64_t> leaf_sizes();

  // How many threads search: fewer than asked for where the system or the evaluator's memory gives no more.
  std::size_t threads() const {
    return evaluator_ ? std::min(search_.threads(), evaluator_->threads()) : search_.threads();
  }

  // As the last plan's search has left it.
  const Tree& tree() const { return search_.tree(); }

  // What its evaluators have done so far. Waits for threads that the last plan left behind, as does
  // `leaf_sizes`.
  EvaluatorStats evaluator_stats();

 private:
  // An action's gains over the default policy's action, in rollout mode.
  struct Candidate {
    int action;
    std::uint64_t samples;
    double gain;         // sum
    double gain_square;  // sum
    double mean() const { return samples ? gain / static_cast<double>(samples) : 0.0; }
    double standard_error() const;
  };

  // What would wait for its device for ever stays behind, with its memory.
  struct DeleteUnlessStuck {
    void operator()(LeafEvaluator* evaluator) const {
      if (!evaluator->is_stuck()) delete evaluator;
    }
  };

  void plan_search(const Belief& belief, StreamKey key, Decision& decision);
  void replace_evaluator();
  void plan_tree(Decision& decision, const RootResult& root);
  void plan_rollout(const Belief& belief, StreamKey key, Decision& decision, const RootResult& root);
  void plan_anytime(const Belief& belief, StreamKey key, Decision& decision, const RootResult& root);
  std::size_t affordable_scenarios(std::size_t actions) const;
  void keep_survivors(int default_action);
  void compare_actions(const Belief& belief, StreamKey key, Clock::time_point end, std::size_t survivors,
                       Decision& decision);
  int compared_action(int default_action) const;
  Status evaluate(const LeafRequest& request, LeafResult& result);
  bool sample_gains(const Belief& belief, StreamKey key, Clock::time_point end, Decision& decision);
  std::size_t batch_until(Clock::time_point end) const;
  void note_rollouts(Clock::duration time, std::size_t count);
  void take_gains(const LeafResult& leaf, Decision& decision);
  void halve();
  const Candidate& best_candidate() const;

  std::unique_ptr<LeafEvaluator, DeleteUnlessStuck> evaluator_;  // null: lost
  Fallback fallback_;
  EvaluatorStats past_stats_;  // of evaluators that were lost
  bool is_device_lost_ = false;
  PlannerOptions options_;
  int horizon_;
  Search search_;
  ScenarioBuffer scenarios_;
  SearchSetup setup_{};
  std::vector<std::uint64_t> leaf_sizes_;  // of rollout mode
  std::vector<Candidate> candidates_;      // by ascending action
  std::vector<int> actions_;               // theirs
  std::vector<int> root_actions_;          // that the tree starts with; empty: all
  std::uint64_t sampled_ = 0;              // scenarios that rollout mode has used
  double rollout_seconds_ = 0.0;           // what one took lately, on a full evaluator
};

// Options for the evaluator of a planner.
EvaluatorOptions evaluator_options(const PlannerOptions& options, const ModelDescriptor& model);

}  // namespace hypgen
