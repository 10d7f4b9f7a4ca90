// SPDX-License-Identifier: Apache-2.0
// The command line of the exact solver.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hypgen/exact/enumeration.hpp"
#include "hypgen/model/descriptor.hpp"

namespace hypgen::exact {

struct ExactOptions {
  EnumerationLimits limits;
  double time = 60.0;
  double gap = 1e-3;
  std::string param_file;
  std::string json_file;
  std::string policy_file;
  bool appl_policy = false;
  std::string load_policy_file;
  std::size_t graph = 0;  // nodes; 0: no graph
  std::string graph_file;
  std::vector<std::string> policy_kinds = {"alpha"};
  std::uint64_t runs = 0;
  std::uint64_t seed = 0;
  int steps = 90;
  std::string dump_file;
  bool quiet = false;
  bool help = false;
  bool version = false;
};

// False and `error` on an unknown option or a bad value.
bool parse_options(int argc, const char* const* argv, ExactOptions& options, std::string& error);

// What --help prints.
std::string help_text(const ModelDescriptor& model, const std::string& program);

}  // namespace hypgen::exact
