// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>

#include "hypgen/model/embedded_model.hpp"

namespace hypgen {

namespace {

using Json = nlohmann::ordered_json;

// The names of more values than this are left out.
constexpr double kMostNames = 4096;

const char* kind_name(ValueKind kind) {
  switch (kind) {
    case ValueKind::kBool:
      return "bool";
    case ValueKind::kInt:
      return "int";
    case ValueKind::kFloat:
      return "float";
    case ValueKind::kNamed:
      return "named";
  }
  return "unknown";
}

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json json_of(const ValueField& field) {
  Json json = {{"name", field.name}, {"type", kind_name(field.kind)}, {"dims", field.dims}};
  if (field.kind == ValueKind::kFloat) {
    json["low"] = number_or_null(field.low);
    json["high"] = number_or_null(field.high);
  } else {
    json["low"] = static_cast<std::int64_t>(field.low);
    json["high"] = static_cast<std::int64_t>(field.high);
  }
  if (field.kind == ValueKind::kNamed && field.high < kMostNames) {
    json["values"] = Json::array();
    for (std::int32_t value = 0; value <= static_cast<std::int32_t>(field.high); ++value)
      json["values"].push_back(field.value_name(value));
  }
  return json;
}

Json json_of(const ParamSpec& param) {
  Json json = {{"name", param.name}, {"dims", param.dims}, {"default", nullptr}};
  if (!param.defaults.empty()) json["default"] = param.defaults;
  return json;
}

}  // namespace

std::size_t value_count(const std::vector<ValueField>& fields) {
  std::size_t count = 0;
  for (const ValueField& field : fields) count += field.length();
  return count;
}

std::string describe(const EmbeddedModel& model) {
  const ModelDescriptor& descriptor = model.descriptor;
  Json json = {{"model", descriptor.name},
               {"file", descriptor.file},
               {"hash", descriptor.hash},
               {"descriptor_version", descriptor.version},
               {"compiler", __VERSION__},
               {"cuda", descriptor.device != nullptr},
               {"discount", descriptor.discount},
               {"horizon", nullptr},
               {"actions", descriptor.action_names},
               {"key_words", model.key_words},
               {"visible", Json::array()},
               {"seen", Json::array()},
               {"hidden", Json::array()},
               {"variables", descriptor.variable_count},
               {"params", Json::array()}};
  if (descriptor.horizon > 0) json["horizon"] = descriptor.horizon;
  for (const ValueField& field : model.visible) {
    json["visible"].push_back(json_of(field));
    json["visible"].back()["drawn"] = field.drawn;
  }
  for (const ValueField& field : model.seen) json["seen"].push_back(json_of(field));
  for (std::size_t i = 0; i < model.hidden.size(); ++i) {
    json["hidden"].push_back(json_of(model.hidden[i]));
    json["hidden"].back()["first"] = descriptor.hidden_variables[i].first;
  }
  for (const ParamSpec& param : descriptor.params) json["params"].push_back(json_of(param));
  return json.dump();
}

}  // namespace hypgen
