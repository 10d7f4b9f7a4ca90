// SPDX-License-Identifier: Apache-2.0
#include "hypgen/solver/json_lines.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "hypgen/math/float_bits.hpp"
#include "marginal_json.hpp"

namespace hypgen {

namespace {

const char* looked_name(Looked looked) {
  switch (looked) {
    case Looked::kNowhere:
      return "nowhere";
    case Looked::kOneStep:
      return "one_step";
    case Looked::kTree:
      return "tree";
  }
  return "unknown";
}

constexpr int kVersion = 1;

using Json = nlohmann::ordered_json;

Json counts(const std::map<Status, std::uint64_t>& statuses) {
  Json json = Json::object();
  for (const auto& [status, count] : statuses) json[status_name(status)] = count;
  return json;
}

// The values of a variable, an array if it has several entries.
Json json_of(const VisibleVariable& variable, const std::int32_t* values) {
  Json json = Json::array();
  for (int i = 0; i < variable.count; ++i) {
    const auto bits = static_cast<std::uint32_t>(values[i]);
    json.push_back(variable.is_float ? Json(math::from_bits(bits)) : Json(values[i]));
  }
  return variable.is_array ? json : json.front();
}

void add_details(const ModelDescriptor& model, const StepDetails& details, Json& json) {
  Json marginals = Json::array(), root = Json::array();
  for (const Marginal& marginal : details.marginals) marginals.push_back(json_of(marginal));
  for (const RootAction& one : details.root) {
    root.push_back({{"action", model.action_names[static_cast<std::size_t>(one.action)]},
                    {"lower", one.lower},
                    {"upper", one.upper},
                    {"visits", one.visits}});
    if (!std::isnan(one.mean)) root.back()["mean"] = one.mean;
  }
  json["marginals"] = std::move(marginals);
  json["marginals_left_out"] = details.marginals_left_out;
  json["root"] = std::move(root);
  json["root_left_out"] = details.root_left_out;
}

}  // namespace

bool JsonLines::open(const std::string& file) {
  out_ = std::make_unique<Output>(file, Output::Kind::kLines);
  return out_->ok();
}

void JsonLines::write_line(const std::string& text) { out_->write(text + "\n"); }

void JsonLines::write_run(const SolverOptions& options, const std::string& device, std::size_t threads) {
  if (out_ == nullptr) return;
  const PlannerOptions& planner = options.planner;
  Json json = {{"type", "run"},
               {"version", kVersion},
               {"model", model_.name},
               {"hash", model_.hash},
               {"discount", model_.discount},
               {"mode", mode_name(planner.mode)},
               {"seed", planner.seed},
               {"runs", options.runs},
               {"first_run", options.first_run},
               {"steps", options.steps},
               {"device", device},
               {"threads", threads},
               {"in_flight", planner.in_flight},
               {"observation_loss", planner.observation_loss},
               {"exploration", planner.exploration},
               {"scenarios", planner.scenarios},
               {"rollouts", planner.rolled},
               {"depth", planner.depth},
               {"xi", planner.target_ratio},
               {"pruning", "auto"},
               {"belief", belief_name(options.belief)},
               {"particles", options.particles},
               {"on_depletion", options.stop_on_depletion ? "stop" : "continue"},
               {"time", nullptr},
               {"period", nullptr},
               {"world_param", nullptr},
               {"start", nullptr},
               {"settings", nullptr},
               {"trials", nullptr}};
  if (planner.pruning != kAutoPruning) json["pruning"] = planner.pruning;
  if (planner.time_limit < 1e9) json["time"] = planner.time_limit;
  if (planner.period > 0.0) json["period"] = planner.period;
  if (!options.world_param_file.empty()) json["world_param"] = options.world_param_file;
  if (!options.start_file.empty()) json["start"] = options.start_file;
  if (!options.settings.empty()) json["settings"] = options.settings;
  if (planner.trial_limit != UINT64_MAX) json["trials"] = planner.trial_limit;
  write_line(json.dump());
}

void JsonLines::write(const StartRecord& start) {
  if (out_ == nullptr || !model_.first_observation_name) return;
  Json json = {{"type", "start"},
               {"episode", start.episode},
               {"observation", model_.first_observation_name(start.visible.data())},
               {"belief", status_name(start.belief_status)},
               {"effective_sample_size", nullptr}};
  if (start.belief_status != Status::kNotKept) json["effective_sample_size"] = start.effective_sample_size;
  write_line(json.dump());
}

void JsonLines::write(const StepRecord& step, const StepDetails* details) {
  if (out_ == nullptr) return;
  const Decision& decision = step.decision;
  Json json = {{"type", "step"},
               {"episode", step.episode},
               {"step", step.step},
               {"action", decision.action},
               {"action_name", model_.action_names[static_cast<std::size_t>(decision.action)]},
               {"reward", step.reward},
               {"terminal", step.terminal},
               {"observation", nullptr},
               {"observation_key", nullptr},
               {"status", status_name(decision.status)},
               {"lower", decision.lower},
               {"upper", decision.upper},
               {"looked", looked_name(decision.looked)},
               {"scenarios", decision.scenarios},
               {"pruning", decision.pruning},
               {"compared_actions", decision.compared_actions},
               {"trials", decision.trials},
               {"expansions", decision.expansions},
               {"nodes", decision.nodes},
               {"children", decision.children},
               {"collisions", decision.collisions},
               {"simulations", decision.simulations},
               {"leaf_scenarios", decision.leaf_scenarios},
               {"max_depth", decision.max_depth},
               {"crossed", decision.crossed},
               {"search_seconds", decision.search_seconds},
               {"waiting_seconds", decision.waiting_seconds},
               {"tree_seconds", decision.tree_seconds},
               {"descent_seconds", decision.descent_seconds},
               {"backup_seconds", decision.backup_seconds},
               {"late_threads", decision.late_threads},
               {"belief", status_name(step.belief_status)},
               {"effective_sample_size", nullptr},
               {"update_seconds", step.update_seconds},
               {"cycle_seconds", step.cycle_seconds},
               {"particles", Json::array()},
               {"effective", Json::array()},
               {"distinct", Json::array()},
               {"surprise", Json::array()},
               {"signature", nullptr}};
  if (step.belief_status != Status::kNotKept) json["effective_sample_size"] = step.effective_sample_size;
  for (const UnitHealth& unit : step.units) {
    json["particles"].push_back(unit.particles);
    json["effective"].push_back(unit.effective);
    json["distinct"].push_back(unit.distinct);
    json["surprise"].push_back(unit.surprise);
  }
  if (decision.signature != 0) json["signature"] = hexadecimal(decision.signature);
  if (!step.terminal) {
    json["observation"] = model_.observation_name(step.observation);
    if (step.observation.size() == 1) {
      json["observation_key"] = step.observation[0];
    } else {
      json["observation_key"] = step.observation;
    }
  }
  if (details != nullptr) add_details(model_, *details, json);
  write_line(json.dump());
}

void JsonLines::write(const EpisodeRecord& episode) {
  if (out_ == nullptr) return;
  Json json = {{"type", "episode"},
               {"episode", episode.episode},
               {"discounted_return", episode.discounted_return},
               {"return", episode.undiscounted_return},
               {"steps", episode.steps},
               {"terminal", episode.terminal},
               {"success", nullptr},
               {"status", status_name(episode.status)},
               {"visible", Json::object()}};
  if (model_.has_success) json["success"] = episode.success;
  const std::int32_t* values = episode.visible.data();
  for (const VisibleVariable& variable : model_.visible_variables) {
    json["visible"][variable.name] = json_of(variable, values);
    values += variable.count;
  }
  write_line(json.dump());
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
