// SPDX-License-Identifier: Apache-2.0
// A model as programs take it: its descriptor, and the types of what their callers give and get.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "hypgen/model/descriptor.hpp"

namespace hypgen {

enum class ValueKind { kBool, kInt, kFloat, kNamed };

// A visible variable or an observation: one value, or an array of them row by row. Values are exported ones
// (model/model.hpp).
struct ValueField {
  std::string name;
  std::vector<int> dims;  // empty: one value
  ValueKind kind = ValueKind::kInt;
  double low = 0.0;  // least value
  double high = 0.0;
  std::function<std::string(std::int32_t)> value_name = {};  // kNamed: of a value
  bool drawn = false;  // of a visible variable: draws decide the value at the start

  std::size_t length() const {
    std::size_t product = 1;
    for (const int dim : dims) product *= static_cast<std::size_t>(dim);
    return product;
  }
};

struct EmbeddedModel {
  ModelDescriptor descriptor;
  std::vector<ValueField> visible = {};  // all visible variables, in the order of export_visible
  std::vector<ValueField> seen = {};     // the digits of the observation key, in order
  std::vector<ValueField> hidden = {};   // the descriptor's hidden variables, with their types
  std::size_t key_words = 1;
};

// The number of values of all fields together.
std::size_t value_count(const std::vector<ValueField>& fields);

// The model as a JSON object: names, types, actions, hash and version.
std::string describe(const EmbeddedModel& model);

}  // namespace hypgen
