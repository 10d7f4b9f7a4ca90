// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/play.hpp"

#include <vector>

#include "hypgen/exact/filter.hpp"

namespace hypgen::exact {
EpisodeRecord play_episode(const ExactModel& model, const AlphaPolicy& policy, World& world,
                           std::uint64_t run, const EpisodeLimits& limits) {
  EpisodeRecord episode;
  episode.episode = run;
  world.reset(run);
  std::vector<std::int32_t> visible(model.starts.empty() ? 1 : model.starts[0].visible.size() + 1);
  world.export_visible(visible.data());
  ExactFilter filter(model);
  if (!filter.init(visible.data())) {
    episode.status = Status::kImpossibleObservation;
    return episode;
  }
  double weight = 1.0;
  for (int t = 0; t < limits.steps; ++t, weight *= limits.discount) {
    if (limits.interrupted()) {
      episode.status = Status::kInterrupted;
      return episode;
    }
    const int action = policy.action(filter.belief());
    if (action < 0 || !world.is_legal(action)) {
      episode.status = Status::kNoLegalAction;
      return episode;
    }
    const WorldStep step = world.step(action);
    episode.discounted_return += weight * step.reward;
    episode.undiscounted_return += step.reward;
    episode.steps = t + 1;
    episode.success = episode.success || step.result.success;
    if (step.result.terminal) {
      episode.terminal = true;
      episode.status = Status::kTerminal;
      return episode;
    }
    // After the last step before a horizon there is no belief, as nothing is done there.
    if (!filter.update(action, step.key) && t + 1 < limits.steps) {
      episode.status = Status::kImpossibleObservation;
      return episode;
    }
  }
  episode.status = Status::kStepLimit;
  return episode;
}

}  // namespace hypgen::exact
