// SPDX-License-Identifier: Apache-2.0
// Whether a solver computes the same however and wherever it does: what --selftest runs.
#pragma once

#include <cstdint>
#include <string>

#include "hypgen/model/descriptor.hpp"

namespace hypgen {

struct SelftestOptions {
  bool wanted = false;
  std::uint32_t lanes = 1000;  // random walks
  std::uint32_t steps = 90;    // of each
  int warps = 0;               // that share a step; 0: several numbers, one after the other
  int threads = 0;             // 0: one for each core
  std::uint64_t seed = 0;
  std::string json_file;  // empty: a table
  bool quiet = false;
};

// Compares walks whose steps are shared by warps, and walks on a GPU if there is one, with plain ones on the
// host. Prints what was compared; gives 0 if all was equal, 1 if not or if the result could not be written.
int selftest(const ModelDescriptor& model, const ModelInstance& instance, const SelftestOptions& options);

}  // namespace hypgen
