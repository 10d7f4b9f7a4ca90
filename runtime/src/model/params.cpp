// SPDX-License-Identifier: Apache-2.0
#include "hypgen/model/params.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "input_text.hpp"

namespace hypgen {

namespace {

using Json = nlohmann::json;

const char* kind_name(ParamKind kind) {
  switch (kind) {
    case ParamKind::kBool:
      return "bool (true or false)";
    case ParamKind::kInt:
      return "integer";
    case ParamKind::kFloat:
      return "number";
    case ParamKind::kProb:
      return "probability";
    case ParamKind::kEnum:
      return "name";
  }
  return "value";
}

std::string number_text(double value) {
  std::ostringstream text;
  text.precision(9);
  text << value;
  return text.str();
}

std::string expected(const ParamSpec& spec) {
  if (spec.kind == ParamKind::kEnum) {
    constexpr std::size_t kMostNames = 12;
    std::string text = "one of ";
    for (std::size_t i = 0; i < spec.value_names.size(); ++i) {
      if (i == kMostNames) return text + ", ...";
      text += (i ? ", " : "") + ('"' + spec.value_names[i] + '"');
    }
    return text;
  }
  if (spec.kind == ParamKind::kBool || (std::isinf(spec.low) && std::isinf(spec.high)))
    return kind_name(spec.kind);
  return std::string(kind_name(spec.kind)) + " from " + number_text(spec.low) + " to " +
         number_text(spec.high);
}

std::string shape(const ParamSpec& spec) {
  if (spec.dims.empty()) return "a single value";
  std::string text = "an array of ";
  for (std::size_t i = 0; i < spec.dims.size(); ++i) text += (i ? " x " : "") + std::to_string(spec.dims[i]);
  return text + " values";
}

bool read_scalar(const Json& json, const ParamSpec& spec, double& value) {
  switch (spec.kind) {
    case ParamKind::kBool:
      if (!json.is_boolean()) return false;
      value = json.get<bool>() ? 1.0 : 0.0;
      return true;
    case ParamKind::kEnum: {
      if (!json.is_string()) return false;
      const auto glyph = spec.glyphs.find(json.get<std::string>());
      if (glyph != spec.glyphs.end()) {
        value = static_cast<double>(glyph->second);
        return true;
      }
      const auto found = std::find(spec.value_names.begin(), spec.value_names.end(), json.get<std::string>());
      value = static_cast<double>(found - spec.value_names.begin()) + spec.low;
      return found != spec.value_names.end();
    }
    case ParamKind::kInt:
      if (!json.is_number()) return false;
      value = json.get<double>();
      if (value != std::floor(value)) return false;
      break;
    case ParamKind::kFloat:
    case ParamKind::kProb:
      if (!json.is_number()) return false;
      value = json.get<double>();
      if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max())) return false;
      value = static_cast<double>(static_cast<float>(value));
      break;
  }
  return spec.low <= value && value <= spec.high;
}

// A short text of what was found.
std::string found(const Json& json) { return excerpt(json.dump()); }

// The characters of a text in UTF-8.
std::vector<std::string> characters(const std::string& text) {
  std::vector<std::string> found;
  for (const char byte : text) {
    const bool continues = (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U;
    if (continues && !found.empty()) {
      found.back() += byte;
    } else {
      found.emplace_back(1, byte);
    }
  }
  return found;
}

// Appends what a row of a grid says, a glyph for each entry.
bool read_row(const std::string& row, const ParamSpec& spec, std::vector<double>& out, std::string& error) {
  const std::vector<std::string> glyphs = characters(row);
  if (glyphs.size() != static_cast<std::size_t>(spec.dims.back())) {
    error = "expected a string of " + std::to_string(spec.dims.back()) + " glyphs, found " +
            std::to_string(glyphs.size()) + " in " + found(Json(row));
    return false;
  }
  for (std::size_t i = 0; i < glyphs.size(); ++i) {
    const auto code = spec.glyphs.find(glyphs[i]);
    if (code == spec.glyphs.end()) {
      error = "'" + glyphs[i] + "' is no glyph of it (character " + std::to_string(i + 1) + " of " +
              found(Json(row)) + "); they are";
      for (const auto& known : spec.glyphs) error += " '" + known.first + "'";
      return false;
    }
    out.push_back(static_cast<double>(code->second));
  }
  return true;
}

// Collects the entries of `json` row-major; `error` stays empty if the shape is wrong. Nested arrays must
// have the param's dimensions, flat ones its length; a string may stand for the last dimension of a grid.
bool read_array(const Json& json, const ParamSpec& spec, std::size_t level, std::vector<double>& out,
                std::string& error) {
  const bool flat = level == 0 && json.is_array() && json.size() == spec.length() &&
                    std::none_of(json.begin(), json.end(), [](const Json& item) { return item.is_array(); });
  if (level == spec.dims.size() && !json.is_array()) {
    double value = 0.0;
    if (!read_scalar(json, spec, value)) {
      error = "expected " + expected(spec) + ", found " + found(json);
      return false;
    }
    out.push_back(value);
    return true;
  }
  if (level + 1 == spec.dims.size() && json.is_string() && !spec.glyphs.empty())
    return read_row(json.get<std::string>(), spec, out, error);
  const bool fits = level < spec.dims.size() && json.is_array() &&
                    (flat || json.size() == static_cast<std::size_t>(spec.dims[level]));
  if (!fits) return false;
  for (const Json& item : json) {
    if (!read_array(item, spec, flat ? spec.dims.size() : level + 1, out, error)) return false;
  }
  return true;
}

std::string known_names(const std::vector<ParamSpec>& specs) {
  if (specs.empty()) return "the model has no params";
  std::string text = "the model's params are ";
  for (std::size_t i = 0; i < specs.size(); ++i) text += (i ? ", " : "") + specs[i].name;
  return text;
}

}  // namespace

bool read_params(const std::string& text, const std::vector<ParamSpec>& specs, ParamValues& values,
                 std::string& error) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos) {
    error = "is empty; expected a JSON object {\"name\": value, ...}";
    return false;
  }
  Json json;
  if (!parse_json(text, json, error)) return false;
  if (!json.is_object()) {
    error = "expected a JSON object {\"name\": value, ...}";
    return false;
  }
  for (const auto& [name, value] : json.items()) {
    const auto spec = std::find_if(specs.begin(), specs.end(),
                                   [&name = name](const ParamSpec& s) { return s.name == name; });
    if (spec == specs.end()) {
      error = "unknown param \"" + excerpt(name) + "\"; " + known_names(specs);
      return false;
    }
    std::vector<double> entries;
    if (!read_array(value, *spec, 0, entries, error)) {
      if (error.empty())
        error = "expected " + shape(*spec) + " (" + expected(*spec) + "), found " + found(value);
      error = "param \"" + name + "\": " + error;
      return false;
    }
    values.set(name, std::move(entries));
  }
  return true;
}

bool read_param_file(const std::string& file, const std::vector<ParamSpec>& specs, ParamValues& values,
                     std::string& error) {
  std::size_t entries = 0;
  for (const ParamSpec& spec : specs) entries += spec.length();
  std::string text;
  if (read_input_file(file, most_input(entries), text, error) && read_params(text, specs, values, error))
    return true;
  error = file + ": " + error;
  return false;
}

bool read_plan_params(const std::string& text, const std::vector<ParamSpec>& specs, ParamValues& values,
                      std::string& error) {
  if (text.empty() || read_params(text, specs, values, error)) return true;
  error = "--settings: " + error;
  return false;
}

bool check_complete(const std::vector<ParamSpec>& specs, const ParamValues& values, std::string& error) {
  for (const ParamSpec& spec : specs) {
    if (values.has(spec.name)) continue;
    error = "param \"" + spec.name + "\" has no value: set it in a file given by --param; expected " +
            (spec.dims.empty() ? "" : shape(spec) + ", each ") + expected(spec);
    return false;
  }
  return true;
}

}  // namespace hypgen
