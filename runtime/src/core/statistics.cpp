// SPDX-License-Identifier: Apache-2.0
#include "hypgen/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

namespace hypgen {

namespace {

// The 97.5 % quantile of Student's t: a table, then the first terms of its expansion about the normal's.
double student97_5(std::size_t freedom) {
  constexpr double kTable[] = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228};
  if (freedom <= std::size(kTable)) return kTable[freedom - 1];
  constexpr double kNormal = 1.959964;
  const double n = static_cast<double>(freedom);
  return kNormal + (kNormal * kNormal * kNormal + kNormal) / (4.0 * n) + 2.8225 / (n * n);
}

}  // namespace

double Samples::mean() const {
  if (values_.empty()) return 0.0;
  return sum_ / static_cast<double>(values_.size());
}

double Samples::standard_deviation() const {
  if (values_.size() < 2) return 0.0;
  const double center = mean();
  double sum = 0.0;
  for (const double value : values_) sum += (value - center) * (value - center);
  return std::sqrt(sum / static_cast<double>(values_.size() - 1));
}

double Samples::interval95() const {
  if (values_.size() < 2) return 0.0;
  return student97_5(values_.size() - 1) * standard_deviation() /
         std::sqrt(static_cast<double>(values_.size()));
}

double Samples::quantile(double share) const {
  if (values_.empty()) return 0.0;
  std::vector<double> sorted = values_;
  std::sort(sorted.begin(), sorted.end());
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::min(sorted.size() - 1, rank > 0 ? rank - 1 : 0)];
}

double histogram_median(const std::vector<std::uint64_t>& counts) {
  const std::uint64_t total = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  std::uint64_t reached = 0;
  for (std::size_t size = 0; size < counts.size(); ++size) {
    reached += counts[size];
    if (total > 0 && 2 * reached >= total) return static_cast<double>(size);
  }
  return 0.0;
}

}  // namespace hypgen
