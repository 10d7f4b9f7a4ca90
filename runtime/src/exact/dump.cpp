// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/dump.hpp"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "hypgen/exact/policy.hpp"

namespace hypgen::exact {

namespace {

using Json = nlohmann::ordered_json;

class Lines {
 public:
  explicit Lines(const std::string& file) : out_(file == "-" ? stdout : std::fopen(file.c_str(), "w")) {}
  ~Lines() { close(); }
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;

  void write(const Json& json) {
    if (out_ == nullptr) return;
    const std::string line = json.dump() + "\n";
    complete_ = std::fwrite(line.data(), 1, line.size(), out_) == line.size() && complete_;
  }

  // Whether all could be written.
  bool close() {
    const bool closed = out_ != nullptr && (out_ == stdout ? std::fflush(out_) : std::fclose(out_)) == 0;
    out_ = nullptr;
    return closed && complete_;
  }

 private:
  std::FILE* out_;
  bool complete_ = true;
};

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

bool dump(const ExactDescriptor& descriptor, const ExactModel& model, const std::string& file) {
  Lines lines(file);
  lines.write(header(descriptor.descriptor, model));
  for (const ExactStart& start : model.starts) lines.write(start_line(model, start));
  for (int state = 0; state < model.states; ++state) lines.write(state_line(descriptor, model, state));
  for (int state = 0; state < model.states; ++state) {
    for (std::size_t a = 0; a < model.actions.size(); ++a) {
      const ExactAction& action = model.actions[a];
      if (std::isinf(action.reward[state])) continue;
      lines.write(row_line(action, static_cast<int>(a), state));
    }
  }
  lines.write({{"type", "end"}});
  return lines.close();
}

}  // namespace hypgen::exact
