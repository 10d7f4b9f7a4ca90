// SPDX-License-Identifier: Apache-2.0
#include "hypgen/model/value_text.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>

#include "hypgen/math/float_bits.hpp"
#include "input_text.hpp"
#include "value_json.hpp"

namespace hypgen {

namespace {

using Json = nlohmann::json;                 // of what is read
using OrderedJson = nlohmann::ordered_json;  // of what is written

float float_of(std::int32_t value) { return math::from_bits(static_cast<std::uint32_t>(value)); }

bool is_in_range(const ValueField& field, std::int32_t value) {
  const double number = field.kind == ValueKind::kFloat ? double{float_of(value)} : value;
  return std::isfinite(number) && field.low <= number && number <= field.high;
}

// Names of so many values fit in a message.
constexpr std::size_t kMostNames = 10;

std::string text_of(double number) { return Json(number).dump(); }

std::string range_of(const ValueField& field) {
  switch (field.kind) {
    case ValueKind::kBool:
      return "true or false";
    case ValueKind::kInt:
      return "an integer from " + std::to_string(static_cast<std::int64_t>(field.low)) + " to " +
             std::to_string(static_cast<std::int64_t>(field.high));
    case ValueKind::kFloat:
      if (std::isinf(field.low) && std::isinf(field.high)) return "a number";
      return "a number from " + text_of(field.low) + " to " + text_of(field.high);
    case ValueKind::kNamed:
      if (field.high < kMostNames) {
        std::vector<std::string> names;
        for (std::int32_t code = 0; code <= field.high; ++code) names.push_back(field.value_name(code));
        return "one of " + listed(names);
      }
      return "a name such as \"" + field.value_name(0) + "\", of code 0 to " +
             std::to_string(static_cast<std::int64_t>(field.high));
  }
  return "";
}

bool refuse(const ValueField& field, const std::string& found, std::string& error) {
  error = field.name + ": expected " + range_of(field) + ", found " + found;
  return false;
}

bool read_name(const ValueField& field, const std::string& name, std::int32_t& out) {
  for (std::int64_t code = 0; code <= static_cast<std::int64_t>(field.high); ++code) {
    out = static_cast<std::int32_t>(code);
    if (field.value_name(out) == name) return true;
  }
  return false;
}

bool read_value(const ValueField& field, const Json& json, std::int32_t& out) {
  switch (field.kind) {
    case ValueKind::kBool:
      if (json.is_boolean()) out = json.get<bool>() ? 1 : 0;
      return json.is_boolean();
    case ValueKind::kInt:
      if (!json.is_number_integer() || !(field.low <= json.get<double>() && json.get<double>() <= field.high))
        return false;
      out = static_cast<std::int32_t>(json.get<std::int64_t>());
      return true;
    case ValueKind::kFloat:
      if (!json.is_number() || std::abs(json.get<double>()) > double{std::numeric_limits<float>::max()})
        return false;
      out = static_cast<std::int32_t>(math::to_bits(static_cast<float>(json.get<double>())));
      return is_in_range(field, out);
    case ValueKind::kNamed:
      if (json.is_string()) return read_name(field, json.get<std::string>(), out);
      if (!json.is_number_integer()) return false;  // otherwise a code, as where there are too many names
      out = static_cast<std::int32_t>(std::clamp<std::int64_t>(json.get<std::int64_t>(), -1, INT32_MAX));
      return is_in_range(field, out);
  }
  return false;
}

void flatten(const Json& json, std::vector<Json>& out) {
  if (!json.is_array()) return out.push_back(json);
  for (const Json& entry : json) flatten(entry, out);
}

OrderedJson json_of(const ValueField& field, std::int32_t value) {
  switch (field.kind) {
    case ValueKind::kBool:
      return value != 0;
    case ValueKind::kInt:
      return value;
    case ValueKind::kFloat:
      return double{float_of(value)};
    case ValueKind::kNamed:
      return field.value_name(value);
  }
  return nullptr;
}

std::string names_of(const std::vector<ValueField>& fields) {
  std::vector<std::string> names;
  for (const ValueField& field : fields) names.push_back(field.name);
  return names.empty() ? "none" : listed(names);
}

}  // namespace

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < kMostNames; ++i) text += (i == 0 ? "" : ", ") + names[i];
  const std::size_t rest = names.size() - std::min(names.size(), kMostNames);
  return rest == 0 ? text : text + " and " + std::to_string(rest) + " more";
}

bool check_values(const std::vector<ValueField>& fields, Span<const std::int32_t> values,
                  std::string& error) {
  const std::size_t count = value_count(fields);
  if (values.size() != count) {
    error = "expected " + std::to_string(count) + " value(s), found " + std::to_string(values.size());
    return false;
  }
  const std::int32_t* value = values.begin();
  for (const ValueField& field : fields) {
    for (std::size_t i = 0; i < field.length(); ++i, ++value) {
      if (is_in_range(field, *value)) continue;
      return refuse(
          field, field.kind == ValueKind::kFloat ? text_of(float_of(*value)) : std::to_string(*value), error);
    }
  }
  return true;
}

bool read_values(const std::string& text, const std::vector<ValueField>& fields,
                 std::vector<std::int32_t>& values, std::vector<bool>& given, std::string& error) {
  Json json;
  if (!parse_json(text, json, error)) return false;
  if (!json.is_object()) {
    error = "expected a JSON object with values by name, found " + excerpt(text);
    return false;
  }
  given.assign(fields.size(), false);
  std::size_t known = 0, first = 0;
  for (std::size_t number = 0; number < fields.size(); first += fields[number].length(), ++number) {
    const ValueField& field = fields[number];
    const auto found = json.find(field.name);
    if (found == json.end()) continue;
    ++known;
    given[number] = true;
    std::vector<Json> entries;
    flatten(*found, entries);
    if (entries.size() != field.length() || found->is_array() == field.dims.empty()) {
      error = field.name + ": expected " +
              (field.dims.empty() ? "one value" : "an array of " + std::to_string(field.length())) +
              ", found " + excerpt(found->dump());
      return false;
    }
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (!read_value(field, entries[i], values[first + i]))
        return refuse(field, excerpt(entries[i].dump()), error);
    }
  }
  if (known == json.size()) return true;
  for (const auto& [name, value] : json.items()) {
    bool is_known = false;
    for (const ValueField& field : fields) is_known = is_known || field.name == name;
    if (!is_known) error = "no value is named " + excerpt(name) + "; the names are: " + names_of(fields);
  }
  return false;
}

bool read_value_name(const ValueField& field, const std::string& name, std::int32_t& value,
                     std::string& error) {
  Json json = name;
  if (field.kind != ValueKind::kNamed && !parse_json(name, json, error)) json = nullptr;
  return read_value(field, json, value) || refuse(field, excerpt(name), error);
}

OrderedJson value_json(const ValueField& field, const std::int32_t* values) {
  if (field.dims.empty()) return json_of(field, *values);
  OrderedJson json = OrderedJson::array();
  for (std::size_t i = 0; i < field.length(); ++i) json.push_back(json_of(field, values[i]));
  return json;
}

OrderedJson values_json(const std::vector<ValueField>& fields, const std::int32_t* values) {
  OrderedJson json = OrderedJson::object();
  for (const ValueField& field : fields) {
    json[field.name] = value_json(field, values);
    values += field.length();
  }
  return json;
}

std::string values_text(const std::vector<ValueField>& fields, const std::vector<std::int32_t>& values) {
  return values_json(fields, values.data()).dump();
}

}  // namespace hypgen
