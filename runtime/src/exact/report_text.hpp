// SPDX-License-Identifier: Apache-2.0
// Text of tables.
#pragma once

#include <string>

namespace hypgen::exact {

// As printf; at most 255 characters.
__attribute__((format(printf, 1, 2))) std::string format(const char* pattern, ...);

// A row of a table.
std::string row(const std::string& name, const std::string& value);

// An interval in six digits, rounded outwards: what is printed holds the value as well.
std::string outwards(double lower, double upper);

}  // namespace hypgen::exact
