// SPDX-License-Identifier: Apache-2.0
// Episodes in which a policy acts on the exact belief, in the worlds that planners meet.
#pragma once

#include <cstdint>

#include "hypgen/episode/episode.hpp"
#include "hypgen/episode/world.hpp"
#include "hypgen/exact/exact_model.hpp"
#include "hypgen/exact/policy.hpp"

namespace hypgen::exact {

// Plays episode `run` of the world: with the same seed its draws are those that a planner's `run_episode`
// meets.
EpisodeRecord play_episode(const ExactModel& model, const AlphaPolicy& policy, World& world,
                           std::uint64_t run, const EpisodeLimits& limits);

}  // namespace hypgen::exact
