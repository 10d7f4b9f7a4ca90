// SPDX-License-Identifier: Apache-2.0
// Summaries of what was measured.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace hypgen {

// Samples in order of arrival.
class Samples {
 public:
  void add(double value) {
    values_.push_back(value);
    sum_ += value;
  }
  std::size_t size() const { return values_.size(); }
  double mean() const;
  double standard_deviation() const;  // of the population that the samples stand for; 0 for fewer than two
  double interval95() const;          // half the width, by Student's t; 0 for fewer than two
  double quantile(double share) const;
  double largest() const { return quantile(1.0); }

 private:
  std::vector<double> values_;
  double sum_ = 0.0;
};

// The median of a histogram: entry n counts items of size n.
double histogram_median(const std::vector<std::uint64_t>& counts);

}  // namespace hypgen
