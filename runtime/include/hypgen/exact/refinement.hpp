// SPDX-License-Identifier: Apache-2.0
// Bounds of long episodes, closed over all their steps at once.
//
// A backup carries a bound over one step, so a search needs as many as an episode has steps until a loop shows
// what it comes to. Here loops are linear equations. Above: the points of the sawtooth bound and the convex
// bound below them are a small decision process, which policy iteration solves (Lovejoy 1991; Hauskrecht 2000
// has the grids). Below: vectors and the vectors that follow them are a controller, which is evaluated
// (Hansen, UAI 1998; Ji et al., AAAI 2007).
#pragma once

#include <map>
#include <vector>

#include "hypgen/exact/belief_graph.hpp"

namespace hypgen::exact {

// Points and, as many, the rows of a belief's states whose corners have no part in the mixture.
struct Mixture {
  std::vector<int> points;
  std::vector<int> rows;
  std::vector<double> weights;  // of the points
};

// Beliefs that bound others from above.
struct UpperPoints {
  std::vector<int> nodes;
  std::map<int, Mixture> mixtures;  // of nodes that are none, their points as nodes
};

// Lowers the bounds at `points` and the convex bound. Then drops points that are never met from the nodes
// `starts`, and takes up beliefs that are often met and lose most by being no points.
void refine_upper(const SplitModel& model, BeliefGraph& graph, const std::vector<int>& starts,
                  UpperPoints& points, const KeepGoing& keep_going);

// Backs up the points, and beliefs that the policy so far meets, and adds the vectors of a controller that is
// made of the best vectors there.
void refine_lower(const SplitModel& model, BeliefGraph& graph, const std::vector<int>& starts,
                  const std::vector<int>& points, const KeepGoing& keep_going);

}  // namespace hypgen::exact
