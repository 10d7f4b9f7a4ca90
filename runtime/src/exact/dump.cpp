// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/dump.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "hypgen/exact/policy.hpp"

namespace hypgen::exact {

namespace {

using Json = nlohmann::ordered_json;

Json header(const ModelDescriptor& descriptor, const ExactModel& model) {
  Json observations = Json::array();
  for (int o = 0; o < model.observations; ++o) {
    const auto words = static_cast<std::size_t>(model.key_words);
    observations.push_back(
        descriptor.observation_name({model.keys.data() + static_cast<std::size_t>(o) * words, words}));
  }
  return {{"type", "model"},
          {"name", descriptor.name},
          {"hash", descriptor.hash},
          {"policy_hash", model_hash(model)},
          {"discount", model.discount},
          {"horizon", model.horizon},
          {"variables", descriptor.variable_names},
          {"actions", descriptor.action_names},
          {"observations", std::move(observations)},
          {"states", model.states}};
}

Json start_line(const ExactModel& model, const ExactStart& start) {
  Json belief = Json::array();
  int of_class = 0;
  for (SparseBelief::InnerIterator entry(start.belief); entry; ++entry) {
    belief.push_back({entry.index(), entry.value()});
    of_class = model.seen[static_cast<std::size_t>(entry.index())];
  }
  return {{"type", "start"}, {"probability", start.probability}, {"class", of_class}, {"belief", belief}};
}

Json state_line(const ExactDescriptor& descriptor, const ExactModel& model, int state) {
  const auto i = static_cast<std::size_t>(state);
  Json json = {{"type", "state"}, {"state", state}, {"class", model.seen[i]}};
  if (!model.steps.empty()) json["step"] = model.steps[i];
  json["values"] =
      descriptor.value_names(model.values.data() + i * static_cast<std::size_t>(model.variables));
  return json;
}

Json row_line(const ExactAction& action, int number, int state) {
  Json outcomes = Json::array();
  std::size_t group = 0;  // columns of a row are in order, and so are observations
  for (SparseMatrix::InnerIterator entry(action.outcomes, state); entry; ++entry) {
    const auto column = static_cast<int>(entry.col());
    while (action.begin[group + 1] <= column) ++group;
    outcomes.push_back(
        {action.observations[group], action.next[static_cast<std::size_t>(column)], entry.value()});
  }
  return {{"type", "row"},
          {"state", state},
          {"action", number},
          {"reward", action.reward[state]},
          {"outcomes", std::move(outcomes)}};
}

}  // namespace

bool dump(const ExactDescriptor& descriptor, const ExactModel& model, Output& out) {
  const auto write = [&](const Json& line) { return out.write(line.dump() + "\n"); };
  write(header(descriptor.descriptor, model));
  for (const ExactStart& start : model.starts) write(start_line(model, start));
  for (int state = 0; state < model.states && out.ok(); ++state) write(state_line(descriptor, model, state));
  for (int state = 0; state < model.states && out.ok(); ++state) {
    for (std::size_t a = 0; a < model.actions.size(); ++a) {
      const ExactAction& action = model.actions[a];
      if (std::isinf(action.reward[state])) continue;
      write(row_line(action, static_cast<int>(a), state));
    }
  }
  write({{"type", "end"}});
  return out.close();
}

}  // namespace hypgen::exact
