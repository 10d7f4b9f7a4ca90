// Chooses actions by search.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "hypgen/belief.hpp"
#include "hypgen/descriptor.hpp"
#include "hypgen/leaf_evaluator.hpp"
#include "hypgen/tree.hpp"

namespace hypgen {

enum class Mode {
  kDespot,   // regularised DESPOT
  kRollout,  // one-ply rollouts of the default policy, sequential halving over the actions
  kDefault,  // the default policy alone
};

struct PlannerOptions {
  Mode mode = Mode::kDespot;
  std::uint64_t seed = 0;
  double time_limit = std::numeric_limits<double>::infinity();            // seconds a decision
  std::uint64_t trial_limit = std::numeric_limits<std::uint64_t>::max();  // a decision
  std::size_t scenarios = 500;                                            // K
  int depth = 90;                                                         // D
  double target_ratio = 0.95;                                             // xi
  double pruning = 0.0;                                                   // lambda
  double gap = 1e-3;  // the search ends when the root's bounds are this close
  double gain_errors =
      1.0;  // kRollout: standard errors of a gain that make another action than the default's
  std::size_t memory_bytes = std::size_t{1} << 30;
  bool signature = false;  // hash every tree, after the deadline
};

// What to do, and what is known about it. `lower` and `upper` bound the value of the belief (regularised if
// pruning is on), up to sampling error.
struct Decision {
  int action = -1;
  Status status = Status::kOk;
  double lower = 0.0;
  double upper = 0.0;
  std::uint64_t trials = 0;
  std::uint64_t expansions = 0;
  std::uint64_t nodes = 0;
  std::uint64_t simulations = 0;     // steps of expansions: scenarios times legal actions
  std::uint64_t leaf_scenarios = 0;  // summed over expansions
  std::uint64_t crossed = 0;         // groups whose bounds crossed
  int max_depth = 0;
  double search_seconds = 0.0;
  std::uint64_t signature = 0;  // of the tree, if asked for
};

// Allocates only when it is made; `plan` works within the memory of its options.
class Planner {
 public:
  Planner(std::unique_ptr<LeafEvaluator> evaluator, const ModelDescriptor& model,
          const PlannerOptions& options);

  // The scenarios' memory is laid out for beliefs of this kind. To be called before the first plan.
  void prepare(const Belief& belief);

  // Decides at time `step` of episode `run`. Always gives a legal action, unless the status is
  // kNoLegalAction.
  Decision plan(const Belief& belief, std::uint64_t run, int step);

  // How many scenarios the leaves expanded so far had: entry n counts leaves with n.
  const std::vector<std::uint64_t>& leaf_sizes() const { return leaf_sizes_; }

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

  void plan_despot(Decision& decision, const RootResult& root);
  void plan_rollout(const Belief& belief, StreamKey key, Decision& decision, const RootResult& root);
  Status run_trial(Decision& decision);
  Status expand(std::uint32_t node, Decision& decision);
  Status evaluate(const LeafRequest& request, LeafResult& result);
  void count_expansion(const LeafResult& leaf, int depth, Decision& decision);
  int best_root_action(int default_action) const;
  bool sample_gains(const Belief& belief, StreamKey key, Clock::time_point end, Decision& decision);
  std::size_t batch_until(Clock::time_point end) const;
  void take_gains(const LeafResult& leaf);
  void halve();
  const Candidate& best_candidate() const;

  std::unique_ptr<LeafEvaluator> evaluator_;
  PlannerOptions options_;
  int horizon_;
  Tree tree_;
  ScenarioBuffer scenarios_;
  SearchSetup setup_{};
  std::vector<std::uint64_t> leaf_sizes_;
  std::vector<Candidate> candidates_;  // by ascending action
  std::vector<int> actions_;           // theirs
  std::uint64_t sampled_ = 0;          // scenarios that rollout mode has used
  double rollout_seconds_ = 0.0;       // what one took lately
};

// Options for the evaluator of a planner.
EvaluatorOptions evaluator_options(const PlannerOptions& options, double discount);

}  // namespace hypgen
