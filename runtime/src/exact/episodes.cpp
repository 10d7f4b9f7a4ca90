// SPDX-License-Identifier: Apache-2.0
#include "episodes.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "hypgen/core/interrupt.hpp"
#include "hypgen/exact/play.hpp"

namespace hypgen::exact {

namespace {

std::string json(const ModelDescriptor& model, const std::string& policy, const EpisodeRecord& episode) {
  nlohmann::ordered_json line = {{"type", "episode"},
                                 {"policy", policy},
                                 {"episode", episode.episode},
                                 {"discounted_return", episode.discounted_return},
                                 {"return", episode.undiscounted_return},
                                 {"steps", episode.steps},
                                 {"terminal", episode.terminal},
                                 {"success", nullptr},
                                 {"status", status_name(episode.status)}};
  if (model.has_success) line["success"] = episode.success;
  return line.dump() + "\n";
}

}  // namespace

NamedPolicy policy_named(const IntervalSolution& solution, const std::string& kind) {
  return {kind, kind == "alpha" ? &solution.alpha : kind == "qmdp" ? &solution.qmdp : &solution.blind};
}

bool play_policy(const ExactDescriptor& model, const ExactInstance& instance, const ExactModel& matrices,
                 const NamedPolicy& policy, const ExactOptions& options, Samples& returns,
                 const std::function<bool(const std::string&)>& write) {
  const ModelDescriptor& descriptor = model.descriptor;
  const int steps = descriptor.horizon > 0 ? std::min(descriptor.horizon, options.steps) : options.steps;
  const EpisodeLimits limits{steps, descriptor.discount, [] { return interrupted(); }};
  const auto world = instance.make_world(options.seed);
  for (std::uint64_t run = 0; run < options.runs && !interrupted(); ++run) {
    const EpisodeRecord episode = play_episode(matrices, *policy.second, *world, run, limits);
    if (episode.status != Status::kInterrupted) returns.add(episode.discounted_return);
    if (!write(json(descriptor, policy.first, episode))) return false;
  }
  return !interrupted();
}

}  // namespace hypgen::exact
