// SPDX-License-Identifier: Apache-2.0
// Parameter files: JSON objects that set a model's params.
#pragma once

#include <string>
#include <vector>

#include "hypgen/model/descriptor.hpp"

namespace hypgen {

// Sets params from JSON text; arrays may be nested or flat, enum values are given by name. False and `error`
// on a syntax error, an unknown key, a wrong shape or type, or a value out of range.
bool read_params(const std::string& text, const std::vector<ParamSpec>& specs, ParamValues& values,
                 std::string& error);

// The same from a file; `error` starts with its name.
bool read_param_file(const std::string& file, const std::vector<ParamSpec>& specs, ParamValues& values,
                     std::string& error);

// The same from the params of settings; `error` says so. Empty text sets nothing.
bool read_plan_params(const std::string& text, const std::vector<ParamSpec>& specs, ParamValues& values,
                      std::string& error);

// Whether every param has values; otherwise names those without.
bool check_complete(const std::vector<ParamSpec>& specs, const ParamValues& values, std::string& error);

}  // namespace hypgen
