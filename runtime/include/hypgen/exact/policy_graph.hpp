// SPDX-License-Identifier: Apache-2.0
// A policy of alpha vectors as a graph: what it does first, and what after each observation.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "hypgen/exact/exact_model.hpp"
#include "hypgen/exact/policy.hpp"

namespace hypgen::exact {

// What leads from one node to another. `to` is -1 if that node is left out.
struct GraphEdge {
  int to;
  double probability;                                // of all of its observations
  std::vector<std::pair<int, double>> observations;  // and the probability of each; likely ones first
};

// A vector of the policy, for all beliefs at which it is the best. `value`, `ends` and the edges' probabilities
// are those of one of them: the one by which the walk first came there.
struct GraphNode {
  int action;
  double value;                  // what the vector promises
  double ends;                   // the probability that the episode is over after the action
  std::vector<GraphEdge> edges;  // likely ones first
};

// Where an episode starts: `to` is a node, -1 if it is left out or nothing is legal.
struct GraphStart {
  std::size_t start;  // index into `ExactModel::starts`
  int to;
};

struct PolicyGraph {
  std::vector<GraphNode> nodes;
  std::vector<GraphStart> starts;
  std::size_t left_out = 0;  // nodes
  bool is_cut_off = false;   // there may be more: the walk was too long
};

// How far a walk goes.
struct WalkLimits {
  std::size_t kept = 20;           // nodes of the graph; the others are counted
  std::size_t found = 10000;       // nodes
  double products = 2e9;           // of a probability and a value, to find the best vectors: some seconds
  std::size_t entries = 20000000;  // of the beliefs that wait
};

// Walks from the starts to what follows, likely nodes first.
PolicyGraph policy_graph(const ExactModel& model, const AlphaPolicy& policy, const WalkLimits& limits);

}  // namespace hypgen::exact
