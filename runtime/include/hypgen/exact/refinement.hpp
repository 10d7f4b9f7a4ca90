// SPDX-License-Identifier: Apache-2.0
// Bounds of long episodes, closed over all their steps at once.
//
// A backup carries a bound over one step, so a search needs as many as an episode has steps until a loop shows
// what it comes to. Here loops are linear equations. Above: the points of the sawtooth bound and the convex
// bound below them are a small decision process, which policy iteration solves (Lovejoy 1991; Hauskrecht 2000
// has the grids). Below: vectors and the vectors that follow them are a controller, which is evaluated
// (Hansen, UAI 1998; Ji et al., AAAI 2007).
#pragma once

#include "hypgen/exact/belief_graph.hpp"

namespace hypgen::exact {

// Whether the model is small enough.
bool can_refine(const SplitModel& model);

// Lowers the bounds at `points`, which are nodes, and the convex bound. Then drops points that are never met
// from the nodes `starts`, and takes up beliefs that are often met and lose most by being no points.
void refine_upper(const SplitModel& model, BeliefGraph& graph, const std::vector<int>& starts,
                  std::vector<int>& points, const KeepGoing& keep_going);

// Backs up the points, and beliefs that the policy so far meets, and adds the vectors of a controller that is
// made of the best vectors there.
void refine_lower(const SplitModel& model, BeliefGraph& graph, const std::vector<int>& starts,
                  const std::vector<int>& points, const KeepGoing& keep_going);

}  // namespace hypgen::exact
