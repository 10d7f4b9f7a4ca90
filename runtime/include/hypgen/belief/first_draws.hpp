// SPDX-License-Identifier: Apache-2.0
// The first particles where the agent sees something before it first acts: many draws of the initial state,
// weighed by what is seen, and a sample of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace hypgen {

// Weights of candidates, which are draws of the initial state numbered from 0. Each column is a belief of
// `size` particles that is weighed and sampled apart from the others.
class FirstDraws {
 public:
  FirstDraws(std::size_t size, std::size_t columns) : size_(size), columns_(columns) {}

  // How many candidates there are by now: the number of the next one.
  std::uint32_t count() const { return static_cast<std::uint32_t>(weights_.size() / columns_); }

  // Takes how likely the next candidate makes what is seen, for each column.
  void add(const double* likelihoods) {
    weights_.insert(weights_.end(), likelihoods, likelihoods + columns_);
  }

  // Whether `size` more candidates are worth drawing: some column's effective sample size is below half of
  // its particles, and the weights may take more memory.
  bool wants_more() const {
    if (count() + size_ > kMostRounds * size_ || (count() + size_) * columns_ > kMostWeights) return false;
    for (std::size_t column = 0; column < columns_; ++column) {
      if (effective_size(column) < 0.5 * static_cast<double>(size_)) return true;
    }
    return false;
  }

  // Calls `take(i, candidate, weight)` for each particle i < size of a column, candidates ascending: all of
  // one round, or a systematic sample of several rounds that `word` places. False if no candidate explains
  // what is seen; then they have the weights of draws that nothing is known of.
  template <class Take>
  bool choose(std::size_t column, std::uint32_t word, const Take& take) const {
    const double total = sum(column);
    const double share = 1.0 / static_cast<double>(size_);
    const bool is_explained = total > 0.0;
    if (!is_explained || count() == size_) {
      for (std::uint32_t i = 0; i < size_; ++i) take(i, i, is_explained ? weight(column, i) / total : share);
      return is_explained;
    }
    std::uint32_t end = count();  // of the candidates with weight: the sum of weights may round to below 1
    while (!(weight(column, end - 1) > 0.0)) --end;
    const double offset = static_cast<double>(word) * 0x1p-32;
    std::uint32_t candidate = 0;
    double reached = weight(column, 0) / total;
    for (std::uint32_t i = 0; i < size_; ++i) {
      const double pointer = (static_cast<double>(i) + offset) * share;
      while (reached <= pointer && candidate + 1 < end) reached += weight(column, ++candidate) / total;
      take(i, candidate, share);
    }
    return true;
  }

 private:
  static constexpr std::size_t kMostRounds = 16;
  static constexpr std::size_t kMostWeights = std::size_t{1} << 22;

  double weight(std::size_t column, std::size_t candidate) const {
    return weights_[candidate * columns_ + column];
  }

  double sum(std::size_t column) const {
    double total = 0.0;
    for (std::size_t i = 0; i < count(); ++i) total += weight(column, i);
    return total;
  }

  double effective_size(std::size_t column) const {
    double squares = 0.0;
    for (std::size_t i = 0; i < count(); ++i) squares += weight(column, i) * weight(column, i);
    const double total = sum(column);
    return squares > 0.0 ? total * total / squares : 0.0;
  }

  std::size_t size_;
  std::size_t columns_;
  std::vector<double> weights_;  // candidate by candidate
};

}  // namespace hypgen
