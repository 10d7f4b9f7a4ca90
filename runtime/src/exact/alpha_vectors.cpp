// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/alpha_vectors.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace hypgen::exact {
namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

std::size_t bytes_of(const AlphaVector& vector) {
  return sizeof(AlphaVector) + vector.values.size() * sizeof(double) + vector.states.size() * sizeof(int) +
         vector.plan.size() * sizeof(const AlphaVector*);
}

// Four sums side by side, as each addition waits for the one before it.
double product(const ClassBelief& belief, const double* values) {
  const int* states = belief.states.data();
  const double* probabilities = belief.probabilities.data();
  const std::size_t size = belief.states.size();
  double sums[4] = {0.0, 0.0, 0.0, 0.0};
  std::size_t i = 0;
  for (; i + 4 <= size; i += 4) {
    for (std::size_t k = 0; k < 4; ++k) sums[k] += probabilities[i + k] * values[states[i + k]];
  }
  for (; i < size; ++i) sums[0] += probabilities[i] * values[states[i]];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

}  // namespace

const AlphaVector* AlphaVector::current() const {
  const AlphaVector* vector = this;
  while (vector->better != nullptr) vector = vector->better;
  return vector;
}

const AlphaVector* AlphaVectors::add(AlphaVector vector) {
  for (const AlphaVector* old : vectors_) {
    if (dominates(*old, vector)) return old;
  }
  all_.push_back(std::make_unique<AlphaVector>(std::move(vector)));
  AlphaVector& added = *all_.back();
  added.sum = sum(added);
  for (AlphaVector* old : vectors_) {
    if (!dominates(added, *old)) continue;
    old->better = &added;
    bytes_ -= bytes_of(*old);
    old->values = {};
    old->states = {};
    old->plan = {};
    bytes_ += bytes_of(*old);
  }
  vectors_.erase(std::remove_if(vectors_.begin(), vectors_.end(),
                                [](const AlphaVector* one) { return one->better != nullptr; }),
                 vectors_.end());
  vectors_.push_back(&added);
  bytes_ += bytes_of(added);
  if (usual_ == nullptr || added.sum > usual_->sum) usual_ = &added;
  return &added;
}

double AlphaVectors::sum(const AlphaVector& vector) const {
  if (vector.states.empty()) return std::accumulate(vector.values.begin(), vector.values.end(), 0.0);
  double sum = std::accumulate(worst_.begin(), worst_.end(), 0.0);
  for (std::size_t i = 0; i < vector.states.size(); ++i) {
    sum += vector.values[i] - worst_[index(vector.states[i])];
  }
  return sum;
}

bool AlphaVectors::dominates(const AlphaVector& a, const AlphaVector& b) const {
  if (b.states.empty()) {
    for (std::size_t s = 0; s < worst_.size(); ++s) {
      if (value(a, static_cast<int>(s)) < b.values[s]) return false;
    }
    return true;
  }
  for (std::size_t i = 0; i < b.states.size(); ++i) {
    if (value(a, b.states[i]) < b.values[i]) return false;
  }
  return true;
}

double AlphaVectors::value(const AlphaVector& vector, int state) const {
  if (vector.states.empty()) return vector.values[index(state)];
  const auto at = std::lower_bound(vector.states.begin(), vector.states.end(), state);
  if (at == vector.states.end() || *at != state) return worst_[index(state)];
  return vector.values[static_cast<std::size_t>(at - vector.states.begin())];
}

double AlphaVectors::value(const AlphaVector& vector, const ClassBelief& belief) const {
  if (vector.states.empty()) return product(belief, vector.values.data());
  double sum = 0.0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < belief.states.size(); ++i) {
    const int state = belief.states[i];
    while (at < vector.states.size() && vector.states[at] < state) ++at;
    const bool known = at < vector.states.size() && vector.states[at] == state;
    sum += belief.probabilities[i] * (known ? vector.values[at] : worst_[index(state)]);
  }
  return sum;
}

void AlphaVectors::raise(const ClassBelief& belief, std::uint64_t from, double& best_value,
                         const AlphaVector*& best) const {
  for (auto it = vectors_.rbegin(); it != vectors_.rend() && (*it)->number >= from; ++it) {
    const double now = value(**it, belief);
    if (best != nullptr && now <= best_value) continue;
    best_value = now;
    best = *it;
  }
}

}  // namespace hypgen::exact
