// SPDX-License-Identifier: Apache-2.0
#include "settings.hpp"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "../model/input_text.hpp"

namespace hypgen {

namespace {

using Json = nlohmann::json;

constexpr const char* kBudgets[] = {"--time", "--period", "--trials"};

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool is_budget(const std::string& name) {
  return std::find(std::begin(kBudgets), std::end(kBudgets), name) != std::end(kBudgets);
}

bool read_object(const std::string& text, Json& json, std::string& error) {
  if (!parse_json(text, json, error)) return false;
  if (!json.is_object()) {
    error = R"(expected a JSON object {"options": {...}, "params": {...}})";
    return false;
  }
  for (const char* part : {"options", "params"}) {
    if (!json.contains(part)) json[part] = Json::object();
    if (json[part].is_object()) continue;
    error = std::string("\"") + part + "\": expected an object, found " + excerpt(json[part].dump());
    return false;
  }
  return true;
}

bool is_known(const std::string& key, std::string& error) {
  if (is_setting(key) && key != "settings") return true;
  error = "no setting is named \"" + excerpt(key) + "\"; the settings are:";
  for (const char* known : kSettings) error += std::string(" ") + known;
  return false;
}

bool take_option(const Option& option, const Json& value, std::string& error) {
  const bool is_switch = option.metavar == nullptr;
  const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
  if (is_switch == value.is_boolean() && option.take(text)) return true;
  error =
      "bad value " + excerpt(value.dump()) + "; expected " + (is_switch ? "true or false" : option.expected);
  return false;
}

bool take_object(const std::string& text, const std::vector<Option>& table, std::vector<std::string>& given,
                 std::string& params, std::string& error) {
  Json json;
  if (!read_object(text, json, error)) return false;
  const std::vector<std::string> before = given;
  const bool has_budget = std::any_of(before.begin(), before.end(), is_budget);
  for (const auto& [key, value] : json["options"].items()) {
    if (!is_known(key, error)) return false;
    const std::string name = "--" + key;
    if (contains(before, name) || (has_budget && is_budget(name)) || value == Json(false)) continue;
    const auto option =
        std::find_if(table.begin(), table.end(), [&](const Option& o) { return name == o.name; });
    if (!take_option(*option, value, error)) {
      error = "\"" + key + "\": " + error;
      return false;
    }
    given.push_back(name);
  }
  if (!json["params"].empty()) params = json["params"].dump();
  return true;
}

}  // namespace

bool is_setting(const std::string& name) {
  return std::find(std::begin(kSettings), std::end(kSettings), name) != std::end(kSettings);
}

bool take_settings(const std::string& file_or_text, const std::vector<Option>& table,
                   std::vector<std::string>& given, std::string& params, std::string& error) {
  const bool is_text = file_or_text.rfind('{', 0) == 0;
  std::string text = file_or_text, problem;
  const bool is_read = is_text || read_input_file(file_or_text, most_input(0), text, problem);
  if (is_read && take_object(text, table, given, params, problem)) return true;
  error = "--settings: " + (is_text ? "" : file_or_text + ": ") + problem;
  return false;
}

}  // namespace hypgen
