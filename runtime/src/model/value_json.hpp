// SPDX-License-Identifier: Apache-2.0
// Values of fields as JSON.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "hypgen/model/embedded_model.hpp"

namespace hypgen {

// A field's value, or a flat array of them. A float that is no finite number is written as null.
nlohmann::ordered_json value_json(const ValueField& field, const std::int32_t* values);

// The object of all fields by name.
nlohmann::ordered_json values_json(const std::vector<ValueField>& fields, const std::int32_t* values);

}  // namespace hypgen
