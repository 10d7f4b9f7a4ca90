// SPDX-License-Identifier: Apache-2.0
// Whether a model computes the same however and wherever it does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "hypgen/verify/verifiable_model.hpp"

namespace hypgen {

struct SelftestOptions {
  std::uint32_t lanes = 1000;  // random walks
  std::uint32_t steps = 90;    // of each
  int warps = 0;               // that share a step; 0: several numbers, one after the other
  std::size_t threads = 1;
  std::uint64_t seed = 0;
  std::string json_file;  // empty: a table
  bool quiet = false;
};

// Compares walks whose steps are shared by warps, and walks on a GPU if there is one, with plain ones on the
// host. Prints what was compared; gives 0 if all was equal, 1 if not or if the result could not be written.
int selftest(const VerifiableModel& model, const VerifiableInstance& instance,
             const SelftestOptions& options);

}  // namespace hypgen
