// SPDX-License-Identifier: Apache-2.0
// The start of an episode as JSON text.
#pragma once

#include <string>

#include "hypgen/model/embedded_model.hpp"
#include "hypgen/model/start_values.hpp"

namespace hypgen {

// Reads a JSON object of visible and hidden variables, or of single entries of them, by name. What it leaves out
// is not given. False and `error` on a syntax error, an unknown name, a value that is given twice, of another type
// or out of range.
bool read_start(const std::string& text, const EmbeddedModel& model, StartValues& start, std::string& error);

// The same from a file; `error` starts with its name.
bool read_start_file(const std::string& file, const EmbeddedModel& model, StartValues& start,
                     std::string& error);

}  // namespace hypgen
