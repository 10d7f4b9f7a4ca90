// SPDX-License-Identifier: Apache-2.0
// Two evaluators of one model side by side: do they give the same rows?
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "hypgen/leaves/leaf_evaluator.hpp"

namespace hypgen {

constexpr std::size_t kMostInFlight = 256;  // leaves that both evaluators are given at once: a full batch

struct LeafComparison {
  std::uint64_t leaves = 0;
  std::uint64_t rows = 0;  // of actions and children
  std::string difference;  // the first; empty: none
};

// Grows the same random tree with both, `leaves` of them in batches of random size, and compares every byte
// of every row. The other one's leaves are dealt to all the threads that it serves. Ends early where memory
// is full.
LeafComparison compare_leaves(LeafEvaluator& reference, LeafEvaluator& other, const ScenarioBuffer& root,
                              const SearchSetup& setup, std::size_t leaves, std::uint64_t seed);

}  // namespace hypgen
