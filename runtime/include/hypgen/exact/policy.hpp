// SPDX-License-Identifier: Apache-2.0
// Policies on the exact belief of a small model.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <stdexcept>
#include <string>
#include <vector>

#include "hypgen/exact/exact_model.hpp"

namespace hypgen::exact {

// A number for all that the solver reads of a model: policies of one model are refused for another.
std::uint64_t model_hash(const ExactModel& model);

// A policy's file is of another model, or damaged.
class PolicyError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Vectors of values for each class of states, each with an action: acts by the vector with the largest
// expected value. With alpha vectors that is worth at least `value` wherever it starts; Q-values of the MDP
// make it QMDP.
class AlphaPolicy {
 public:
  // Values of the class's states, which are numbered from its first: of `states`, ascending, or of all if
  // that is empty.
  struct Vector {
    int action;
    std::vector<int> states;
    std::vector<double> values;
  };
  struct Class {
    std::vector<Vector> vectors;  // none where nothing is legal
    std::vector<double>
        rest;  // what a vector is worth in states that it does not list; empty if all list all
  };

  AlphaPolicy() = default;
  // `classes` are in the order of `ExactModel::class_begin`.
  AlphaPolicy(const ExactModel& model, std::vector<Class> classes);

  // The action at a belief over states of one class; -1 where nothing is legal. Of equals the first.
  int action(const SparseBelief& belief) const;
  // The largest expected value; 0 where nothing is legal.
  double value(const SparseBelief& belief) const;

  // The vector that both come from; null where nothing is legal.
  const Vector* best(const SparseBelief& belief, double& value) const;

  const std::vector<Class>& classes() const { return classes_; }
  // How many vectors the class of a belief has.
  std::size_t vectors_at(const SparseBelief& belief) const;

 private:
  std::vector<int> seen_;
  std::vector<int> class_begin_;
  std::vector<Class> classes_;
};

// Text: a line with the model's hash and the number of classes; for each class a line with the numbers of its
// vectors and of values of the rest, and these; for each vector a line with its action, how many states it
// lists (0: all), and values, after their states if these are listed. Reading it back gives equal numbers.
void write_policy(std::ostream& out, const ExactModel& model, const AlphaPolicy& policy);
// Throws PolicyError.
AlphaPolicy read_policy(std::istream& in, const ExactModel& model);

}  // namespace hypgen::exact
