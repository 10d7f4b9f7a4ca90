// SPDX-License-Identifier: Apache-2.0
#include "state_names.hpp"

#include <algorithm>

namespace hypgen::exact {

namespace {

const std::int32_t* row_of(const ExactModel& model, int state) {
  return model.values.data() + static_cast<std::size_t>(state) * static_cast<std::size_t>(model.variables);
}

}  // namespace

std::vector<std::string> values_of(const ExactDescriptor& descriptor, const ExactModel& model, int state) {
  return descriptor.value_names(row_of(model, state));
}

int first_state(const ExactModel& model, std::size_t start) {
  SparseBelief::InnerIterator some(model.starts[start].belief);
  return some ? static_cast<int>(some.index()) : 0;
}

std::vector<int> states_of_starts(const ExactModel& model) {
  std::vector<int> states;
  for (std::size_t i = 0; i < model.starts.size(); ++i) states.push_back(first_state(model, i));
  return states;
}

SeenNames::SeenNames(const ExactDescriptor& descriptor, const ExactModel& model,
                     const std::vector<int>& states)
    : descriptor_(descriptor), model_(model) {
  std::vector<char> hidden(static_cast<std::size_t>(model.variables), 0);
  for (const HiddenVariable& variable : descriptor.descriptor.hidden_variables) {
    const auto first = hidden.begin() + variable.first;
    std::fill(first, first + variable.count, 1);
  }
  for (std::size_t i = 0; i < hidden.size(); ++i) {
    const auto differs = [&](int state) { return row_of(model, state)[i] != row_of(model, states[0])[i]; };
    if (hidden[i] != 0 || std::none_of(states.begin(), states.end(), differs)) continue;
    if (variables_.size() == kMostVariables) has_more_ = true;
    if (variables_.size() < kMostVariables) variables_.push_back(i);
  }
}

std::string SeenNames::of(int state) const {
  std::string text;
  if (variables_.empty()) return text;
  const std::vector<std::string> values = values_of(descriptor_, model_, state);
  const std::vector<std::string>& names = descriptor_.descriptor.variable_names;
  for (const std::size_t i : variables_) {
    if (!text.empty()) text += ", ";
    if (i < names.size()) text += names[i] + "=";
    text += values[i];
  }
  return has_more_ ? text + ", ..." : text;
}

}  // namespace hypgen::exact
