// SPDX-License-Identifier: Apache-2.0
#include "hypgen/episode/episode.hpp"

namespace hypgen {

EpisodeRecord run_episode(Planner& planner, Belief& belief, World& world, int visible_count,
                          std::uint64_t run, const EpisodeLimits& limits,
                          const std::function<void(const StepRecord&)>& report,
                          const std::function<void(const StartRecord&)>& report_start) {
  EpisodeRecord episode;
  episode.episode = run;
  std::vector<std::int32_t> visible(static_cast<std::size_t>(visible_count) + 1);
  world.reset(run);
  world.export_visible(visible.data());
  const Status begun = belief.init(visible.data(), run);
  visible.pop_back();
  const bool is_kept = belief.knows_hidden();
  if (report_start)
    report_start({run, visible, is_kept ? begun : Status::kNotKept, belief.effective_sample_size()});
  if (begun != Status::kOk && limits.stop_on_depletion) {
    episode.status = begun;
    return episode;
  }
  double weight = 1.0, update_seconds = 0.0;
  for (int t = 0; t < limits.steps; ++t, weight *= limits.discount) {
    if (limits.interrupted()) {
      episode.status = Status::kInterrupted;
      return episode;
    }
    if (limits.period > 0.0) planner.set_time_limit(rest_of_period(limits.period, update_seconds));
    const Decision decision = planner.plan(belief, run, t);
    if (decision.action < 0 || !world.is_legal(decision.action)) {
      episode.status = Status::kNoLegalAction;
      return episode;
    }
    if (limits.decided) limits.decided(decision);
    const WorldStep step = world.step(decision.action);
    episode.discounted_return += weight * step.reward;
    episode.undiscounted_return += step.reward;
    episode.steps = t + 1;
    episode.success = episode.success || step.result.success;
    const Clock::time_point start = Clock::now();
    const Status believed = step.result.terminal ? Status::kOk : belief.update(decision.action, step.key);
    const bool stops = believed != Status::kOk && limits.stop_on_depletion;
    if (believed != Status::kOk && !stops) belief.propagate(decision.action, step.key);
    StepRecord record;
    record.cycle_seconds = update_seconds + decision.search_seconds;
    update_seconds = std::chrono::duration<double>(Clock::now() - start).count();
    record.update_seconds = update_seconds;
    record.episode = run;
    record.step = t;
    record.decision = decision;
    record.reward = step.reward;
    record.terminal = step.result.terminal;
    record.is_broken = step.result.is_broken();
    record.observation.assign(step.key.begin(), step.key.end());
    record.belief_status = is_kept ? believed : Status::kNotKept;
    record.units = belief.health();
    record.effective_sample_size = belief.effective_sample_size();
    report(record);
    if (step.result.terminal) {
      episode.terminal = true;
      episode.status = Status::kTerminal;
      return episode;
    }
    if (stops) {
      episode.status = believed;
      return episode;
    }
  }
  episode.status = Status::kStepLimit;
  return episode;
}

}  // namespace hypgen
