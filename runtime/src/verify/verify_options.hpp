// SPDX-License-Identifier: Apache-2.0
// The command line of the program that checks a model's code.
#pragma once

#include <string>

#include "hypgen/model/descriptor.hpp"
#include "hypgen/verify/belief_check.hpp"
#include "hypgen/verify/bounds_check.hpp"
#include "hypgen/verify/selftest.hpp"
#include "hypgen/verify/trace.hpp"

namespace hypgen {

// What to do: a trace if it has a file, a check of bounds or beliefs if it has any, otherwise a self-test.
struct VerifyOptions {
  TraceOptions trace;
  SelftestOptions selftest;
  BoundsCheckOptions bounds;
  BeliefCheckOptions beliefs;
  std::string param_file;
  bool help = false;
  bool version = false;
};

// False and `error` on an unknown option, a bad value or two tasks at once. `cores`: threads unless the command
// line says how many.
bool parse_options(int argc, const char* const* argv, std::size_t cores, VerifyOptions& options,
                   std::string& error);

// What --help prints.
std::string verify_help(const ModelDescriptor& model, const std::string& program);

}  // namespace hypgen
