// SPDX-License-Identifier: Apache-2.0
// The lower bound of a class of states: the largest of its alpha vectors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "hypgen/exact/bounds.hpp"

namespace hypgen::exact {

// A belief within a class: states, numbered from the class's first and ascending, and their probabilities.
struct ClassBelief {
  std::vector<int> states;
  std::vector<double> probabilities;
};

// At most the value, in each state of its class, of a policy that starts with an action of the class. It is
// exact where it was computed: at `states` (empty: everywhere); at others it is the worst value.
struct AlphaVector {
  std::uint64_t number = 0;  // in order of making, over all classes
  int choice = -1;           // index of the class's actions; -1 where nothing is legal
  std::vector<int> states;
  std::vector<double> values;
  // Where loops count (`SplitModel::closes_loops`): what follows each outcome of the action. Empty if nothing does.
  std::vector<const AlphaVector*> plan{};
  double sum = 0.0;
  // No state is worth less, nor is one that the policy comes to later.
  double least = 0.0;
  const AlphaVector* better = nullptr;  // set once: a vector that is nowhere less

  // The vector that stands for this one.
  const AlphaVector* current() const;
};

// The vectors of one class. A vector stays where it is as long as the set; what is dominated gives its memory
// back and names a better one.
class AlphaVectors {
 public:
  // `worst` are the worst values of the class's states.
  explicit AlphaVectors(std::vector<double> worst) : worst_(std::move(worst)) {}

  const std::vector<double>& worst() const { return worst_; }

  // Adds a vector unless an old one is nowhere less; what it dominates goes. Returns the one that counts.
  const AlphaVector* add(AlphaVector vector);

  double value(const AlphaVector& vector, const ClassBelief& belief) const;
  // The value in a single state.
  double value(const AlphaVector& vector, int state) const;
  // Raises `value` to the best of vectors that are not older than `from`, and says which it is in `best`.
  void raise(const ClassBelief& belief, std::uint64_t from, double& value, const AlphaVector*& best) const;

  // A vector for beliefs that nobody has looked at: the one with the largest sum.
  const AlphaVector* usual() const { return usual_->current(); }
  // Those that nothing dominates, in order of making.
  const std::vector<AlphaVector*>& vectors() const { return vectors_; }
  // How many have been added, those that are dominated now included.
  std::size_t made() const { return all_.size(); }
  std::size_t bytes() const { return bytes_; }

 private:
  bool dominates(const AlphaVector& a, const AlphaVector& b) const;
  double sum(const AlphaVector& vector) const;

  std::vector<double> worst_;
  std::vector<std::unique_ptr<AlphaVector>> all_;
  std::vector<AlphaVector*> vectors_;
  const AlphaVector* usual_ = nullptr;
  std::size_t bytes_ = 0;
};

}  // namespace hypgen::exact
