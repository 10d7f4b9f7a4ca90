// SPDX-License-Identifier: Apache-2.0
#include "first_report.hpp"

#include <algorithm>

#include "report_text.hpp"
#include "state_names.hpp"

namespace hypgen::exact {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kShownDecisions = 3;
constexpr std::size_t kShownActions = 10;
constexpr std::size_t kMostActions = 1000;  // of a JSON object

const std::string& name_of(const ModelDescriptor& model, int action) {
  return model.action_names[static_cast<std::size_t>(action)];
}

std::string left_out(std::size_t all, std::size_t shown, const char* what) {
  return all > shown ? row("  ...", format("and %zu more %s", all - shown, what)) : "";
}

std::string best_row(const NamedDecision& named) {
  const double regret = named.decision.regret();
  std::string text = named.action;
  if (!named.seen.empty()) text += " after the start " + named.seen + format(" (%.3g)", named.probability);
  if (named.decision.actions.size() > 1)
    text += regret > 0.0 ? format("; no other is better by more than %.3g", regret) : "; no other is better";
  return row("first action", text);
}

}  // namespace

std::vector<NamedDecision> named_decisions(const ExactDescriptor& descriptor, const ExactModel& model,
                                           const std::vector<FirstDecision>& decisions) {
  const std::vector<int> states = states_of_starts(model);
  const SeenNames names(descriptor, model, states);
  std::vector<NamedDecision> named;
  for (const FirstDecision& decision : decisions) {
    named.push_back({model.starts[decision.start].probability, names.of(states[decision.start]),
                     decision.action < 0 ? "none" : name_of(descriptor.descriptor, decision.action),
                     decision});
  }
  return named;
}

std::string first_rows(const ModelDescriptor& model, const std::vector<NamedDecision>& decisions,
                       std::size_t starts) {
  if (decisions.empty()) return "";
  std::string rows;
  const std::size_t shown = std::min(decisions.size(), kShownDecisions);
  for (std::size_t i = 0; i < shown; ++i) rows += best_row(decisions[i]);
  rows += left_out(starts, shown, "ways to start");
  const std::vector<ActionBounds>& actions = decisions[0].decision.actions;
  const std::size_t listed = std::min(actions.size(), kShownActions);
  for (std::size_t i = 0; i < listed; ++i) {
    rows += row("  " + name_of(model, actions[i].action), outwards(actions[i].lower, actions[i].upper));
  }
  return rows + left_out(actions.size(), listed, "actions");
}

Json first_json(const ModelDescriptor& model, const std::vector<NamedDecision>& decisions) {
  Json array = Json::array();
  for (const NamedDecision& named : decisions) {
    const std::vector<ActionBounds>& all = named.decision.actions;
    Json actions = Json::array();
    for (std::size_t i = 0; i < std::min(all.size(), kMostActions); ++i) {
      actions.push_back(
          {{"action", name_of(model, all[i].action)}, {"lower", all[i].lower}, {"upper", all[i].upper}});
    }
    Json object = {{"probability", named.probability},
                   {"seen", nullptr},
                   {"best_action", nullptr},
                   {"regret", named.decision.regret()},
                   {"actions", std::move(actions)},
                   {"actions_left_out", all.size() - std::min(all.size(), kMostActions)}};
    if (!named.seen.empty()) object["seen"] = named.seen;
    if (named.decision.action >= 0) object["best_action"] = named.action;
    array.push_back(std::move(object));
  }
  return array;
}

}  // namespace hypgen::exact
