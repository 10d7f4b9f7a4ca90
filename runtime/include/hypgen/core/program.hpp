// SPDX-License-Identifier: Apache-2.0
// How hypgen's programs end, and what they say then.
#pragma once

#include <string>

#include "hypgen/core/output.hpp"

namespace hypgen {

// Exit codes. A signal that ends a program adds its number to 128 (interrupt.hpp).
constexpr int kDone = 0, kFailed = 1, kWrongUse = 2;
constexpr int kReaderIsGone = 141;  // of standard output; as SIGPIPE ends other programs

// From now on a write to a closed pipe, or beyond a limit of the system, fails instead of ending the process.
void let_writes_fail();

// Tells a message, after the name of the program's model; gives `code`.
int complain(const std::string& name, const std::string& message, int code);

// Tells why results could not be written, unless their reader has gone; gives the exit code.
int complain(const std::string& name, const Output& out);

// Writes a text to a file, whole or not at all, or prints it; gives the exit code.
int print(const std::string& name, const std::string& text, const std::string& file = "-");

}  // namespace hypgen
