// SPDX-License-Identifier: Apache-2.0
// Points and the convex bound below them as a decision process, which policy iteration solves.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "hypgen/exact/chain.hpp"
#include "hypgen/exact/refinement.hpp"
#include "mixture.hpp"

namespace hypgen::exact {

// The upper bound as a decision process. Its unknowns are the values of the points and, of each state and
// action, those of the convex bound. What follows an action is a point, or a mixture of points and a rest of
// which the convex bound is taken, with one action for all of its states. `choose_points` and what it asks for
// are in refine_upper.cpp.
class PointProcess {
 public:
  PointProcess(const SplitModel& model, BeliefGraph& graph, UpperPoints& points)
      : model_(model), graph_(graph), points_(points) {}

  void gather();
  // False if it was cut off, or has no solution: then nothing is better than before.
  bool solve(const KeepGoing& keep_going);
  void give_back();
  void keep_mixtures();
  void choose_points(const std::vector<int>& starts, const KeepGoing& keep_going);

 private:
  struct Branch {
    double probability;
    int after;
  };
  struct Move {
    double reward;
    std::vector<Branch> branches;
  };
  // A belief that follows.
  struct After {
    int node;
    int of_class;
    ClassBelief belief;
    int own = -1;                // the point that it is
    Mixture mixture{};           // of its class's points
    Mixture cheapest{};          // the last that was found, whether it is in use or not
    std::vector<double> rest{};  // what the mixture leaves of each of the belief's states
    int action = 0;              // for the rest
  };
  struct ClassPoints {
    std::vector<int> points;
    PricedPoints priced;
  };
  struct Rest {
    double value;
    int action;
  };

  int after_of(int node);
  void leave_rest(After& after) const;
  Move move_of(int node, int choice);
  std::size_t unknown(int of_class, int state, std::size_t action) const;
  int point_of(const After& after, std::size_t part) const;
  double value_of_rest(const After& after, std::size_t action) const;
  Rest best_rest(const After& after) const;
  double value(const After& after) const;
  double value(const Move& move) const;
  void price_points();
  bool mix(After& after, double enough);
  bool improve_actions();
  bool improve_mixtures();
  bool evaluate();
  Chain chain() const;
  double backed_up(int node);
  double spread(const After& after) const;
  void lead(Chain& chain, int from, const Move& move) const;

  const SplitModel& model_;
  BeliefGraph& graph_;
  UpperPoints& points_;
  std::vector<ClassPoints> classes_;
  std::vector<std::vector<Move>> moves_;  // of each point
  std::vector<int> chosen_;               // of each point's moves
  std::vector<std::size_t> convex_begin_;
  std::vector<Move> convex_;  // of each state and action, behind the points
  std::vector<After> afters_;
  std::map<int, int> after_of_node_;
  std::map<int, std::pair<int, int>> point_of_node_;  // its number, and that in its class
  std::vector<double> values_;
};

}  // namespace hypgen::exact
