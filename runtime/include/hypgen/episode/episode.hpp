// SPDX-License-Identifier: Apache-2.0
// One episode: plan, act, update the belief.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/core/status.hpp"
#include "hypgen/episode/world.hpp"
#include "hypgen/search/planner.hpp"

namespace hypgen {

// How an episode began: what was visible, and what the belief made of it.
struct StartRecord {
  std::uint64_t episode = 0;
  std::vector<std::int32_t> visible;
  Status belief_status = Status::kOk;
  double effective_sample_size = 0.0;
};

// What happened in a step. `observation` is all zeroes if the step was terminal.
struct StepRecord {
  std::uint64_t episode = 0;
  int step = 0;
  Decision decision;
  double reward = 0.0;
  bool terminal = false;
  bool is_broken = false;                  // the reward was no number, or beyond the range of rewards
  std::vector<std::uint64_t> observation;  // the words of its key
  Status belief_status = Status::kOk;
  double effective_sample_size = 0.0;
  double update_seconds = 0.0;    // of the belief's update
  double cycle_seconds = 0.0;     // of the update before this step, and the plan
  std::vector<UnitHealth> units;  // of the belief
};

// How an episode went.
struct EpisodeRecord {
  std::uint64_t episode = 0;
  double discounted_return = 0.0;
  double undiscounted_return = 0.0;
  int steps = 0;
  bool terminal = false;
  bool success = false;
  Status status = Status::kOk;
  std::vector<std::int32_t> visible;  // the world's visible variables at the end
};

struct EpisodeLimits {
  int steps = 0;
  double discount = 1.0;
  std::function<bool()> interrupted;
  bool stop_on_depletion = false;  // end where no particle explains what was seen
  // Is told of each decision before the step is taken, while the belief is the one that it was made for.
  std::function<void(const Decision&)> decided{};
  double period =
      0.0;  // seconds that an update and the plan after it have together; 0: the planner's own limit
};

// Runs episode `run` and reports its start and each step as they happen. Episode numbers name the world's
// draws, so that planners can be compared on the same worlds.
EpisodeRecord run_episode(Planner& planner, Belief& belief, World& world, int visible_count,
                          std::uint64_t run, const EpisodeLimits& limits,
                          const std::function<void(const StepRecord&)>& report,
                          const std::function<void(const StartRecord&)>& report_start = {});

}  // namespace hypgen
