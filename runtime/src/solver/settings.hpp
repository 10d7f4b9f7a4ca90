// SPDX-License-Identifier: Apache-2.0
// Settings: the options that are about planning, and the JSON objects that hold some of them.
#pragma once

#include <string>
#include <vector>

#include "option_table.hpp"

namespace hypgen {

constexpr const char* kSettings[] = {
    "mode",        "time",      "period",    "trials",        "threads", "in-flight",   "observation-loss",
    "exploration", "device",    "scenarios", "rollouts",      "depth",   "xi",          "pruning",
    "belief",      "particles", "memory",    "device-memory", "seed",    "require-gpu", "signature",
    "settings"};

bool is_setting(const std::string& name);

// Takes the options of a settings file, or of its text, that are not `given` yet, and adds their names. `params`
// becomes the JSON text of the params to plan with; empty where there are none. False and `error` if they are wrong.
bool take_settings(const std::string& file_or_text, const std::vector<Option>& table,
                   std::vector<std::string>& given, std::string& params, std::string& error);

}  // namespace hypgen
