// SPDX-License-Identifier: Apache-2.0
// The totals of a run.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "hypgen/core/statistics.hpp"
#include "hypgen/episode/episode.hpp"
#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/model/descriptor.hpp"

namespace hypgen {

// Totals over all steps and episodes of a run.
struct RunTotals {
  Samples returns;
  Samples episode_steps;
  Samples seconds;                // of planning, a step
  Samples updates;                // seconds of the belief's updates, a step
  Samples cycles;                 // seconds of a plan and the update before it
  double period = 0.0;            // seconds that a cycle may take; 0: not limited
  std::uint64_t late_cycles = 0;  // that took a millisecond longer, or more
  std::uint64_t depleted = 0;     // steps after which some unit's particles had few values left
  std::uint64_t surprised = 0;    // steps that saw what the belief had all but excluded
  std::uint64_t unexplained = 0;  // steps that saw what no particle explained
  std::uint64_t broken = 0;       // steps without a search, or a reward, as a bound or reward was no number
  std::uint64_t successes = 0;
  std::uint64_t trials = 0;
  std::uint64_t expansions = 0;
  std::uint64_t nodes = 0;
  std::uint64_t children = 0;
  std::uint64_t collisions = 0;
  std::uint64_t simulations = 0;
  std::uint64_t leaf_scenarios = 0;
  std::uint64_t signature = 0;
  std::uint64_t trees = 0;           // steps in which a tree looked ahead
  std::uint64_t tree_scenarios = 0;  // summed over them
  std::uint64_t pruned = 0;          // of them, those with a lambda above 0
  double pruning = 0.0;              // lambda, summed over them
  std::uint64_t compared = 0;        // steps in which one-ply rollouts alone decided
  // Steps in which rollouts compared actions, before a tree or alone, and how many actions in all.
  std::uint64_t comparisons = 0;
  std::uint64_t compared_actions = 0;
  std::string mode;
  std::uint64_t late_searches = 0;  // that ended without waiting for a thread
  std::size_t threads = 1;          // of a search
  std::size_t in_flight = 1;
  double search_seconds = 0.0;
  double waiting_seconds = 0.0;
  double tree_seconds = 0.0;
  double descent_seconds = 0.0;
  double backup_seconds = 0.0;
  EvaluatorStats evaluator;
  std::map<Status, std::uint64_t> plan_statuses;
  std::map<Status, std::uint64_t> belief_statuses;  // of steps, and of starts that nothing explains
  std::map<Status, std::uint64_t> episode_statuses;

  void add(const StartRecord& start);
  void add(const StepRecord& step);
  void add(const EpisodeRecord& episode);
  double a_second(std::uint64_t count) const {
    return search_seconds > 0 ? static_cast<double>(count) / search_seconds : 0.0;
  }
  double a_step(std::uint64_t count) const {
    return seconds.size() ? static_cast<double>(count) / static_cast<double>(seconds.size()) : 0.0;
  }
  double a_batch() const {
    return evaluator.batches ? static_cast<double>(evaluator.leaves) / static_cast<double>(evaluator.batches)
                             : 0.0;
  }
  double a_leaf() const {
    return expansions ? static_cast<double>(leaf_scenarios) / static_cast<double>(expansions) : 0.0;
  }
};

// What is wrong with the model, in lines; empty where no bound and reward was anything but a number.
std::vector<std::string> faults(const RunTotals& totals, const ModelDescriptor& model);

// A signature as reports have it.
std::string hexadecimal(std::uint64_t signature);

// The table at the end of a run.
std::string table(const RunTotals& totals, const ModelDescriptor& model,
                  const std::vector<std::uint64_t>& leaf_sizes);

}  // namespace hypgen
