// SPDX-License-Identifier: Apache-2.0
#include "hypgen/model/start_text.hpp"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "hypgen/model/value_text.hpp"
#include "input_text.hpp"

namespace hypgen {

namespace {

using Json = nlohmann::json;

// Part of a state: a variable, or an entry of one.
struct Place {
  ValueField field;
  std::size_t first;  // in export_state
};

// All variables in the order of export_state, where hidden ones have their places and visible ones the rest.
std::vector<Place> variables_of(const EmbeddedModel& model) {
  std::vector<Place> found;
  std::size_t first = 0, visible = 0, hidden = 0;
  while (visible < model.visible.size() || hidden < model.hidden.size()) {
    const bool is_hidden =
        hidden < model.hidden.size() &&
        (visible == model.visible.size() ||
         static_cast<std::size_t>(model.descriptor.hidden_variables[hidden].first) == first);
    found.push_back({is_hidden ? model.hidden[hidden++] : model.visible[visible++], first});
    first += found.back().field.length();
  }
  return found;
}

// The name of the entry at a place of export_state.
std::string entry_name(const EmbeddedModel& model, const Place& variable, std::size_t entry) {
  const std::vector<std::string>& names = model.descriptor.variable_names;
  const std::size_t place = variable.first + entry;
  return place < names.size() ? names[place] : variable.field.name + "[" + std::to_string(entry) + "]";
}

bool find(const EmbeddedModel& model, const std::vector<Place>& variables, const std::string& name,
          Place& found) {
  for (const Place& variable : variables) {
    found = variable;
    if (variable.field.name == name) return true;
    if (name.rfind(variable.field.name + "[", 0) != 0) continue;
    found.field.name = name;
    found.field.dims.clear();
    for (std::size_t entry = 0; entry < variable.field.length(); ++entry, ++found.first)
      if (entry_name(model, variable, entry) == name) return true;
  }
  return false;
}

std::string names_of(const std::vector<Place>& variables) {
  std::vector<std::string> names;
  for (const Place& variable : variables) names.push_back(variable.field.name);
  return listed(names);
}

}  // namespace

bool read_start(const std::string& text, const EmbeddedModel& model, StartValues& start, std::string& error) {
  Json json;
  if (!parse_json(text, json, error)) return false;
  if (!json.is_object()) {
    error = R"(expected a JSON object {"variable": value, ...}, found )" + excerpt(text);
    return false;
  }
  const std::vector<Place> variables = variables_of(model);
  const auto count = static_cast<std::size_t>(model.descriptor.variable_count);
  StartValues read{std::vector<std::int32_t>(count), std::vector<std::uint8_t>(count)};
  for (const auto& [name, value] : json.items()) {
    Place place;
    if (!find(model, variables, name, place)) {
      error = "no variable is named " + excerpt(name) + "; the variables are: " + names_of(variables);
      return false;
    }
    std::vector<std::int32_t> values(place.field.length());
    std::vector<bool> is_named;
    if (!read_values(Json{{name, value}}.dump(), {place.field}, values, is_named, error)) return false;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (read.given[place.first + i] != 0) {
        error = name + ": is given twice, as a whole and by its entries";
        return false;
      }
      read.given[place.first + i] = 1;
      read.values[place.first + i] = values[i];
    }
  }
  start = std::move(read);
  return true;
}

bool read_start_file(const std::string& file, const EmbeddedModel& model, StartValues& start,
                     std::string& error) {
  const auto count = static_cast<std::size_t>(model.descriptor.variable_count);
  std::string text;
  if (read_input_file(file, most_input(count), text, error) && read_start(text, model, start, error))
    return true;
  error = file + ": " + error;
  return false;
}

}  // namespace hypgen
