// SPDX-License-Identifier: Apache-2.0
// Values of fields as JSON text, and their ranges.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hypgen/core/span.hpp"
#include "hypgen/model/embedded_model.hpp"

namespace hypgen {

// The first of some names, for messages.
std::string listed(const std::vector<std::string>& names);

// Whether there are as many values as the fields have, each in the range of its field; otherwise `error` names
// the first that is not.
bool check_values(const std::vector<ValueField>& fields, Span<const std::int32_t> values, std::string& error);

// Reads a JSON object of fields by name into `values`, which has the values of all fields. An array is flat or
// nested. `given` tells which fields were named. False and `error` on a syntax error, an unknown name, or a
// value of another type or out of range.
bool read_values(const std::string& text, const std::vector<ValueField>& fields,
                 std::vector<std::int32_t>& values, std::vector<bool>& given, std::string& error);

// Reads one value by its name: that of a code, true or false, or a number.
bool read_value_name(const ValueField& field, const std::string& name, std::int32_t& value,
                     std::string& error);

// The JSON object that `read_values` reads.
std::string values_text(const std::vector<ValueField>& fields, const std::vector<std::int32_t>& values);

}  // namespace hypgen
