// SPDX-License-Identifier: Apache-2.0
// Beliefs that can be reached from the start, with bounds of their values: where the search of interval.hpp
// walks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "hypgen/exact/alpha_vectors.hpp"
#include "hypgen/exact/sawtooth.hpp"

namespace hypgen::exact {

// The belief after an action and what was seen then.
struct Successor {
  double probability;  // of seeing that; what is missing to 1 over all successors ends the episode
  int node;
  int outcome;  // index into `ClassAction::outcomes`
};

// An action at a belief.
struct Choice {
  double upper = 0.0;   // never rises
  double reward = 0.0;  // expected
  bool expanded = false;
  std::vector<Successor> successors;
};

struct BeliefNode {
  int of_class;
  ClassBelief belief;
  std::vector<double> base;          // of the class's upper bound (`Sawtooth::base`)
  double lower;                      // never falls
  double upper;                      // never rises
  const AlphaVector* best;           // gives `lower`
  std::uint64_t vectors_before = 0;  // older ones have been looked at, and older points
  std::uint64_t points_before = 0;
  int point = -1;               // its own in the class's upper bound
  std::vector<Choice> choices;  // of each action of the class
};

// Bounds are looked at when they are needed: of an action only while it may be the best by its upper bound,
// and of vectors and points only those that were not there the last time.
class BeliefGraph {
 public:
  explicit BeliefGraph(const SplitModel& model) : model_(model) {}

  // No policy is worth less in any state.
  void set_worst(double worst) { worst_ = worst; }

  // The bounds of a class, to be called for each class in order.
  void add_class(AlphaVectors vectors, Sawtooth upper);
  const AlphaVector* add(int of_class, AlphaVector vector);

  // The node of a belief, which is made if there is none.
  int node_of(int of_class, ClassBelief belief);
  BeliefNode& operator[](int node) { return nodes_[static_cast<std::size_t>(node)]; }

  // The bounds by all vectors and points so far.
  double lower(int node);
  double upper(int node);
  // The choice with the largest upper bound, which is as low as present points make it; -1 if nothing is
  // legal.
  int best_choice(int node);
  // Lowers the node's upper bound and raises its lower bound by what its successors have, if by more than
  // `nothing`.
  void back_up(int node, double nothing);

  // Finds what can follow each action.
  void open(int node);
  // The node's choices, those with a larger upper bound first.
  std::vector<int> choices_by_upper(int node);
  // Lowers a choice's upper bound to what follows from its successors, which are found if they are not known.
  void look_at(int node, int choice);
  // At least what the choice is worth: by its successors where these are known, by the vectors that start with
  // it, and by the worst policy from the next step on.
  double choice_lower(int node, int choice);
  // Lowers the node's upper bound to what has been proven elsewhere.
  void lower_upper(int node, double value);
  // Of each state of a class and legal action: the convex bound below the points.
  const std::vector<double>& convex_bound(int of_class) const {
    return upper_[static_cast<std::size_t>(of_class)].vectors();
  }
  // Lowers it where `vectors` are lower; then `look_again`.
  void lower_convex_bound(int of_class, const std::vector<double>& vectors);
  void look_again();

  // Forgets all nodes; vectors and points stay.
  void clear();
  void prune_points();

  // Grows with each vector, point or expansion: a trial that leaves it alone would be the same again.
  std::uint64_t changes() const { return vectors_made_ + points_made_ + expansions_; }
  std::size_t nodes() const { return nodes_.size(); }
  std::size_t points() const;
  std::size_t vectors() const;
  std::size_t node_bytes() const { return node_bytes_; }
  std::size_t bound_bytes() const;
  const std::vector<AlphaVectors>& lower_bounds() const { return lower_; }

 private:
  void make_choices(int node);
  void expand(int node, int choice);
  double worst_after(int node, int choice) const;
  double lower_by_successors(const Choice& choice);
  int best_by_lower(int node, double& value);
  AlphaVector vector_of(int node, int choice);
  std::vector<int> columns_reached(const ClassAction& action, const BeliefNode& node);

  const SplitModel& model_;
  double worst_ = 0.0;
  std::vector<AlphaVectors> lower_;
  std::vector<Sawtooth> upper_;
  std::vector<BeliefNode> nodes_;
  std::unordered_multimap<std::uint64_t, int> by_belief_;
  std::uint64_t vectors_made_ = 0;
  std::uint64_t points_made_ = 0;
  std::uint64_t expansions_ = 0;
  std::size_t node_bytes_ = 0;
  std::vector<double> sums_;  // of columns; zeroes between calls
};

}  // namespace hypgen::exact
