// SPDX-License-Identifier: Apache-2.0
#include "hypgen/solver/json_lines.hpp"

#include <nlohmann/json.hpp>

#include "run_json.hpp"

namespace hypgen {

namespace {

using Json = nlohmann::ordered_json;

Json counts(const std::map<Status, std::uint64_t>& statuses) {
  Json json = Json::object();
  for (const auto& [status, count] : statuses) json[status_name(status)] = count;
  return json;
}

}  // namespace

bool JsonLines::open(const std::string& file) {
  out_ = std::make_unique<Output>(file, Output::Kind::kLines);
  return out_->ok();
}

void JsonLines::write_line(const std::string& text) { out_->write(text + "\n"); }

void JsonLines::write_run(const SolverOptions& options, const std::string& device, std::size_t threads) {
  if (out_ != nullptr) write_line(run_json(model_, options, device, threads).dump());
}

void JsonLines::write(const StartRecord& start) {
  if (out_ != nullptr && model_.first_observation_name) write_line(start_json(model_, start).dump());
}

void JsonLines::write(const StepRecord& step, const StepDetails* details) {
  if (out_ != nullptr) write_line(step_json(model_, step, details).dump());
}

void JsonLines::write(const EpisodeRecord& episode) {
  if (out_ != nullptr) write_line(episode_json(model_, episode).dump());
}

void JsonLines::write_summary(const RunTotals& totals, const std::vector<std::uint64_t>& leaf_sizes) {
  if (out_ == nullptr) return;
  Json json = {{"type", "summary"},
               {"episodes", totals.returns.size()},
               {"discounted_return", totals.returns.mean()},
               {"interval95", nullptr},
               {"success_rate", nullptr},
               {"steps", totals.seconds.size()},
               {"steps_an_episode", totals.episode_steps.mean()},
               {"seconds_mean", totals.seconds.mean()},
               {"seconds_p99", totals.seconds.quantile(0.99)},
               {"seconds_worst", totals.seconds.largest()},
               {"trials_a_step", totals.a_step(totals.trials)},
               {"expansions_a_second", totals.a_second(totals.expansions)},
               {"nodes_a_second", totals.a_second(totals.nodes)},
               {"children_a_second", totals.a_second(totals.children)},
               {"simulations_a_second", totals.a_second(totals.simulations)},
               {"scenarios_a_leaf", totals.a_leaf()},
               {"scenarios_a_leaf_median", histogram_median(leaf_sizes)},
               {"batches", totals.evaluator.batches},
               {"leaves_a_batch", totals.a_batch()},
               {"host_leaves", totals.evaluator.host_leaves},
               {"evaluator_steps_a_second", totals.a_second(totals.evaluator.steps)},
               {"bytes_read", totals.evaluator.bytes_read},
               {"seconds_kernels", totals.evaluator.busy_seconds},
               {"seconds_waiting", totals.waiting_seconds},
               {"seconds_tree", totals.tree_seconds},
               {"seconds_descent", totals.descent_seconds},
               {"seconds_backup", totals.backup_seconds},
               {"update_seconds_mean", totals.updates.mean()},
               {"update_seconds_p99", totals.updates.quantile(0.99)},
               {"update_seconds_worst", totals.updates.largest()},
               {"cycle_seconds_mean", totals.cycles.mean()},
               {"cycle_seconds_p99", totals.cycles.quantile(0.99)},
               {"cycle_seconds_worst", totals.cycles.largest()},
               {"late_cycles", totals.late_cycles},
               {"depleted_steps", totals.depleted},
               {"surprised_steps", totals.surprised},
               {"broken_steps", totals.broken},
               {"searches", counts(totals.plan_statuses)},
               {"beliefs", counts(totals.belief_statuses)},
               {"endings", counts(totals.episode_statuses)},
               {"signature", nullptr}};
  if (totals.signature != 0) json["signature"] = hexadecimal(totals.signature);
  if (model_.has_success && totals.returns.size() > 0) {
    json["success_rate"] = static_cast<double>(totals.successes) / static_cast<double>(totals.returns.size());
  }
  if (totals.returns.size() >= 2) json["interval95"] = totals.returns.interval95();
  write_line(json.dump());
}

}  // namespace hypgen
