// SPDX-License-Identifier: Apache-2.0
#include "hypgen/solver/recording.hpp"

#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "../model/value_json.hpp"
#include "hypgen/leaves/scenario_walk.hpp"
#include "hypgen/solver/step_details.hpp"
#include "marginal_json.hpp"
#include "run_json.hpp"

namespace hypgen {

namespace {

constexpr int kVersion = 1;
constexpr std::uint64_t kSampleStream = std::uint64_t{1} << 62;  // other streams of tests are below

using Json = nlohmann::ordered_json;

Json json_of(const ParamSpec& param, const std::vector<double>& values) {
  Json json = Json::array();
  for (const double value : values) {
    switch (param.kind) {
      case ParamKind::kBool:
        json.push_back(value != 0.0);
        break;
      case ParamKind::kInt:
        json.push_back(static_cast<std::int64_t>(value));
        break;
      case ParamKind::kEnum:
        json.push_back(param.value_names[static_cast<std::size_t>(value)]);
        break;
      case ParamKind::kFloat:
      case ParamKind::kProb:
        json.push_back(value);
        break;
    }
  }
  return param.dims.empty() ? json.front() : json;
}

Json json_of(const std::vector<ParamSpec>& params, const ParamValues& values) {
  Json json = Json::object();
  std::string error;
  for (const ParamSpec& param : params) {
    std::vector<double> found(param.length());
    if (values.copy(param.name.c_str(), found.data(), found.size(), error))
      json[param.name] = json_of(param, found);
  }
  return json;
}

// The object with members that are text already, of the form `,"name":value`.
std::string with_members(const Json& object, const std::string& members) {
  std::string text = object.dump();
  text.pop_back();
  return text + members + "}\n";
}

}  // namespace

bool Recording::open(const std::string& file) {
  out_ = std::make_unique<Output>(file, Output::Kind::kLines);
  return out_->ok();
}

void Recording::write_run(const ParamValues& params, const std::string& device, std::size_t threads) {
  if (out_ == nullptr) return;
  const ModelDescriptor& descriptor = recorded_.model.descriptor;
  const Json described = Json::parse(describe(recorded_.model));
  Json options = run_json(descriptor, recorded_.options, device, threads);
  for (const char* const name : {"type", "version", "model", "hash", "discount"}) options.erase(name);
  Json json = {{"type", "recording"},
               {"version", kVersion},
               {"kind", "episode"},
               {"model", descriptor.name},
               {"hash", descriptor.hash},
               {"file", descriptor.file},
               {"discount", descriptor.discount},
               {"horizon", described["horizon"]},
               {"options", std::move(options)},
               {"params", json_of(descriptor.params, params)},
               {"actions", descriptor.action_names},
               {"variables", Json::array()},
               {"seen", described["seen"]}};
  for (const char* const kind : {"visible", "hidden"}) {
    for (Json variable : described[kind]) {
      for (const char* const name : {"first", "drawn"}) variable.erase(name);
      variable["visible"] = std::string(kind) == "visible";
      json["variables"].push_back(std::move(variable));
    }
  }
  out_->write(json.dump() + "\n");
}

void Recording::write(const StartRecord& start) {
  if (out_ == nullptr) return;
  Json json = start_json(recorded_.model.descriptor, start);
  json["visible"] = values_json(recorded_.model.visible, start.visible.data());
  out_->write(json.dump() + "\n");
}

// All variables of the world, by name.
std::string Recording::state() const {
  const ModelDescriptor& descriptor = recorded_.model.descriptor;
  std::vector<std::int32_t> visible(static_cast<std::size_t>(descriptor.visible_count) + 1);
  std::vector<std::int32_t> values(static_cast<std::size_t>(descriptor.variable_count) + 1);
  recorded_.world.export_visible(visible.data());
  recorded_.world.export_state(values.data());
  Json json = values_json(recorded_.model.visible, visible.data());
  for (std::size_t i = 0; i < recorded_.model.hidden.size(); ++i) {
    const ValueField& field = recorded_.model.hidden[i];
    json[field.name] = value_json(field, values.data() + descriptor.hidden_variables[i].first);
  }
  return json.dump();
}

// States drawn from the belief: each hidden variable's values, state by state.
std::string Recording::sampled(const Belief& belief, std::uint64_t episode, int step) const {
  const ModelDescriptor& descriptor = recorded_.model.descriptor;
  ScenarioBuffer states;
  belief.reserve(states, kSamples);
  const StreamKey key = derive(recorded_.options.planner.seed, StreamKind::kTest,
                               kSampleStream + (episode << 20) + static_cast<std::uint64_t>(step));
  belief.sample(key, 0, kSamples, states);
  const auto width = static_cast<std::size_t>(descriptor.variable_count);
  std::vector<std::int32_t> values(width * kSamples + 1);
  recorded_.believed.export_states(states, values.data());
  Json json = Json::object();
  for (std::size_t i = 0; i < recorded_.model.hidden.size(); ++i) {
    const ValueField& field = recorded_.model.hidden[i];
    Json& column = json[field.name] = Json::array();
    const auto first = static_cast<std::size_t>(descriptor.hidden_variables[i].first);
    for (std::size_t n = 0; n < kSamples; ++n)
      column.push_back(value_json(field, values.data() + n * width + first));
  }
  return json.dump();
}

void Recording::keep(const Belief& belief, Planner& planner, const Decision& decision, std::uint64_t episode,
                     int step) {
  if (out_ == nullptr) return;
  const EmbeddedModel& model = recorded_.model;
  Json marginals_json = nullptr;
  kept_ = ",\"state\":" + state();
  if (belief.knows_hidden()) {
    std::size_t left_out = 0;
    marginals_json = Json::array();
    for (const Marginal& one : marginals(model.descriptor, belief, SIZE_MAX, SIZE_MAX, left_out))
      marginals_json.push_back(hypgen::json_of(one));
    kept_ += ",\"sampled\":" + sampled(belief, episode, step) +
             ",\"particles_total\":" + std::to_string(belief.size());
  } else {
    kept_ += ",\"sampled\":null,\"particles_total\":null";
  }
  const int action = belief.default_action(planner.search_key());
  const Json default_action =
      action < 0 ? Json(nullptr) : Json(model.descriptor.action_names[static_cast<std::size_t>(action)]);
  kept_ += ",\"marginals\":" + marginals_json.dump() + ",\"default_action\":" + default_action.dump();
  Json compared = nullptr;
  if (decision.compared_actions > 0) {
    compared = Json::array();
    for (const ComparedAction& one : planner.compared()) {
      compared.push_back({{"name", model.descriptor.action_names[static_cast<std::size_t>(one.action)]},
                          {"gain", one.gain},
                          {"standard_error", one.standard_error},
                          {"samples", one.samples}});
    }
  }
  kept_ += ",\"compared\":" + compared.dump();
  TreeText text{"null", 0};
  std::size_t size = 0;
  if (decision.keeps_tree && !planner.tree_at_rest().is_empty()) {
    const Tree& tree = planner.tree_at_rest();
    const auto walk = recorded_.believed.walk(planner.scenarios(), planner.search_key(), tree.is_weighted());
    text = tree_text(model, codec_, tree, *walk, kExtent);
    size = tree_size(tree);
  }
  kept_ += ",\"tree\":" + text.json + ",\"tree_shown\":" + std::to_string(text.shown) +
           ",\"tree_total\":" + std::to_string(size);
}

void Recording::write(const StepRecord& step) {
  if (out_ == nullptr) return;
  Json seen = nullptr;
  std::vector<std::int32_t> values;
  if (!step.terminal && codec_.decode({step.observation.data(), step.observation.size()}, values))
    seen = values_json(recorded_.model.seen, values.data());
  Json json = step_json(recorded_.model.descriptor, step, nullptr);
  json["seen"] = std::move(seen);
  out_->write(with_members(json, kept_));
}

void Recording::write(const EpisodeRecord& episode) {
  if (out_ == nullptr) return;
  out_->write(with_members(episode_json(recorded_.model.descriptor, episode), ",\"state\":" + state()));
}

}  // namespace hypgen
