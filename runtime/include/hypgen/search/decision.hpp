// SPDX-License-Identifier: Apache-2.0
// The options and the result of a planner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "hypgen/core/status.hpp"

namespace hypgen {

enum class Mode {
  kDespot,    // regularised DESPOT
  kParallel,  // the same by several threads
  kGpu,       // by one, with many trials in flight, on a GPU
  kHyp,       // by several, on a GPU: HyP-DESPOT
  kPomcp,     // actions by their mean return and UCB1
  kRollout,   // one-ply rollouts of the default policy, sequential halving over the actions
  kDefault,   // the default policy alone
};

// How a tree branches on what is seen.
enum class Observations {
  kExact,     // scenarios that see the same stay together
  kWeighted,  // scenarios are shared by a few observations, with weights
};

constexpr bool wants_gpu(Mode mode) { return mode == Mode::kGpu || mode == Mode::kHyp; }
constexpr bool has_many_threads(Mode mode) { return mode == Mode::kParallel || mode == Mode::kHyp; }
constexpr bool may_have_threads(Mode mode) { return has_many_threads(mode) || mode == Mode::kPomcp; }

// How far a decision has looked.
enum class Looked {
  kNowhere,  // the default policy acts
  kOneStep,  // the actions' one-ply rollouts are compared
  kTree,     // a tree has looked further
};

// The comparison of actions sets lambda; without a time limit there is none, and lambda is 0.
constexpr double kAutoPruning = -1.0;

struct PlannerOptions {
  Mode mode = Mode::kDespot;
  std::uint64_t seed = 0;
  double time_limit = std::numeric_limits<double>::infinity();  // seconds a decision
  double period = 0.0;  // seconds of a belief's update and a decision together; 0: time_limit alone counts
  std::uint64_t trial_limit = std::numeric_limits<std::uint64_t>::max();  // trials a decision
  std::size_t scenarios = 500;                                            // K
  int depth = 90;                                                         // D
  double target_ratio = 0.95;                                             // xi
  double pruning = kAutoPruning;                                          // lambda
  Observations observations = Observations::kExact;
  double observation_loss = 1.0;      // c_o
  double exploration = 0.0;           // c_a; kPomcp: UCB1's constant
  std::uint32_t rolled = 3;           // M, actions that a leaf rolls out
  std::uint32_t rolled_at_root = 16;  // the same at the root, if more
  std::size_t in_flight = 1;          // F, trials at a time; 1 is DESPOT
  std::size_t threads = 1;            // N, of the search
  double gap = 1e-3;  // the search ends when the root's bounds are this close, times reward_scale
  // kRollout leaves the default policy's action for one that gains at least so many standard errors.
  double gain_errors = 1.0;
  double patience = 10.0;                           // seconds of silence after which an evaluator has failed
  std::size_t memory_bytes = std::size_t{1} << 30;  // of the tree and of an evaluator on the host
  std::size_t device_memory_bytes = 0;              // of a GPU; 0: half of what is free, at most 8 GB
  bool lanes = true;       // rollouts side by side, where the model and the processor have lanes
  bool signature = false;  // hash every tree, after the deadline
};

// An action, and what the search found out. `lower` and `upper` bound the value of the belief up to sampling
// error. The value is regularised if pruning is on. Both bounds are NaN where nothing was searched.
struct Decision {
  int action = -1;
  Status status = Status::kOk;
  double lower = std::numeric_limits<double>::quiet_NaN();
  double upper = std::numeric_limits<double>::quiet_NaN();
  Looked looked = Looked::kNowhere;
  bool keeps_tree = false;           // the planner still has the tree that has looked ahead
  std::size_t scenarios = 0;         // of the tree; 0: there was none
  double pruning = 0.0;              // lambda of the tree
  std::size_t compared_actions = 0;  // by one-ply rollouts, before the tree or alone; 0: there was no time
  std::uint64_t trials = 0;
  std::uint64_t expansions = 0;
  std::uint64_t nodes = 0;           // that trials visited
  std::uint64_t children = 0;        // of expanded nodes, visited or not
  std::uint64_t collisions = 0;      // times a trial met what others had in expansion, and turned
  std::uint64_t simulations = 0;     // steps of expansions: scenarios times legal actions
  std::uint64_t leaf_scenarios = 0;  // summed over expansions
  std::uint64_t crossed = 0;         // groups whose bounds crossed
  int max_depth = 0;
  double search_seconds = 0.0;   // the whole decision
  double waiting_seconds = 0.0;  // for leaves, mean of the threads; an evaluator on the CPU works meanwhile
  double tree_seconds = 0.0;     // the rest of a tree search
  double descent_seconds = 0.0;  // of that, walks down to leaves, mean of the threads; from a sample of walks
  double backup_seconds = 0.0;   // of that, walks back up, in the same way
  std::size_t late_threads = 0;  // that had not ended by the deadline
  std::uint64_t signature = 0;   // of the tree, if asked for

  // Takes over what an earlier stage of the same decision has found. Bounds of that stage stay too, if it was a
  // tree.
  void take_answer(const Decision& earlier) {
    action = earlier.action;
    looked = earlier.looked;
    scenarios = earlier.scenarios;
    pruning = earlier.pruning;
    if (looked != Looked::kTree) return;
    lower = earlier.lower;
    upper = earlier.upper;
  }

  // Adds what another stage of the same decision has done.
  void add_work(const Decision& other) {
    compared_actions = compared_actions > other.compared_actions ? compared_actions : other.compared_actions;
    trials += other.trials;
    expansions += other.expansions;
    nodes += other.nodes;
    children += other.children;
    collisions += other.collisions;
    simulations += other.simulations;
    leaf_scenarios += other.leaf_scenarios;
    crossed += other.crossed;
    max_depth = max_depth > other.max_depth ? max_depth : other.max_depth;
    waiting_seconds += other.waiting_seconds;
    tree_seconds += other.tree_seconds;
    descent_seconds += other.descent_seconds;
    backup_seconds += other.backup_seconds;
  }
};

// What the tree's root says of one of its actions, in the terms of `Decision`.
struct RootAction {
  int action = -1;
  double lower = 0.0;
  double upper = 0.0;
  double mean = std::numeric_limits<double>::quiet_NaN();  // of the returns, in kPomcp
  std::uint64_t visits = 0;                                // trials that took it
};

// What rollouts on common random numbers say of an action: its mean gain over the default policy's action.
struct ComparedAction {
  int action = -1;
  double gain = 0.0;
  double standard_error = 0.0;  // of the paired differences
  std::uint64_t samples = 0;
};

}  // namespace hypgen
