// SPDX-License-Identifier: Apache-2.0
#include "run_json.hpp"

#include <cmath>
#include <utility>

#include "hypgen/lanes/choice.hpp"
#include "hypgen/math/float_bits.hpp"
#include "marginal_json.hpp"

namespace hypgen {

using Json = nlohmann::ordered_json;

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

Json run_json(const ModelDescriptor& model, const SolverOptions& options, const std::string& device,
              std::size_t threads) {
  const PlannerOptions& planner = options.planner;
  Json json = {{"type", "run"},
               {"version", kVersion},
               {"model", model.name},
               {"hash", model.hash},
               {"discount", model.discount},
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
               {"lanes", nullptr},
               {"depth", planner.depth},
               {"xi", planner.target_ratio},
               {"observations", planner.observations == Observations::kWeighted ? "weighted" : "exact"},
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
  const hypgen_lanes::Kernel* const lanes = planner.lanes ? first_lanes(model.lanes) : nullptr;
  if (lanes != nullptr) json["lanes"] = lanes->name;
  if (planner.pruning != kAutoPruning) json["pruning"] = planner.pruning;
  if (planner.time_limit < 1e9) json["time"] = planner.time_limit;
  if (planner.period > 0.0) json["period"] = planner.period;
  if (!options.world_param_file.empty()) json["world_param"] = options.world_param_file;
  if (!options.start_file.empty()) json["start"] = options.start_file;
  if (!options.settings.empty()) json["settings"] = options.settings;
  if (planner.trial_limit != UINT64_MAX) json["trials"] = planner.trial_limit;
  return json;
}

Json start_json(const ModelDescriptor& model, const StartRecord& start) {
  Json json = {{"type", "start"},
               {"episode", start.episode},
               {"observation", nullptr},
               {"belief", status_name(start.belief_status)},
               {"effective_sample_size", nullptr}};
  if (model.first_observation_name) json["observation"] = model.first_observation_name(start.visible.data());
  if (start.belief_status != Status::kNotKept) json["effective_sample_size"] = start.effective_sample_size;
  return json;
}

Json step_json(const ModelDescriptor& model, const StepRecord& step, const StepDetails* details) {
  const Decision& decision = step.decision;
  Json json = {{"type", "step"},
               {"episode", step.episode},
               {"step", step.step},
               {"action", decision.action},
               {"action_name", model.action_names[static_cast<std::size_t>(decision.action)]},
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
    json["observation"] = model.observation_name(step.observation);
    if (step.observation.size() == 1) {
      json["observation_key"] = step.observation[0];
    } else {
      json["observation_key"] = step.observation;
    }
  }
  if (details != nullptr) add_details(model, *details, json);
  return json;
}

Json episode_json(const ModelDescriptor& model, const EpisodeRecord& episode) {
  Json json = {{"type", "episode"},
               {"episode", episode.episode},
               {"discounted_return", episode.discounted_return},
               {"return", episode.undiscounted_return},
               {"steps", episode.steps},
               {"terminal", episode.terminal},
               {"success", nullptr},
               {"status", status_name(episode.status)},
               {"visible", Json::object()}};
  if (model.has_success) json["success"] = episode.success;
  const std::int32_t* values = episode.visible.data();
  for (const VisibleVariable& variable : model.visible_variables) {
    json["visible"][variable.name] = json_of(variable, values);
    values += variable.count;
  }
  return json;
}

}  // namespace hypgen
