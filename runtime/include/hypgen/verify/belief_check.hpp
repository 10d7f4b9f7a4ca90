// SPDX-License-Identifier: Apache-2.0
// Simulation-based calibration of the belief (Talts et al., 2018).
//
// In each episode the belief is stopped at one step, which is drawn before. There each hidden variable gets the
// rank u = P(X < x) + v P(X = x) of its true value x in the belief, with v uniform in 0 .. 1. If the belief is
// right, u is uniform too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "hypgen/model/descriptor.hpp"

namespace hypgen {

struct BeliefCheckOptions {
  std::uint64_t episodes = 0;  // 0: no check
  int steps = 90;              // most of an episode
  std::size_t threads = 1;
  std::uint64_t seed = 0;
  BeliefKind belief = BeliefKind::kAuto;
  std::size_t particles = 5000;
  std::string json_file;  // empty: standard output
};

// Writes a JSON line with the ranks of each episode, in the order in which they are done. Gives 0; 1 if the
// lines could not be written; 128 and the signal's number if it was interrupted.
int check_beliefs(const ModelDescriptor& model, const ModelInstance& instance,
                  const BeliefCheckOptions& options);

}  // namespace hypgen
