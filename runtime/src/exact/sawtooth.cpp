// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/sawtooth.hpp"

#include <algorithm>
#include <numeric>

namespace hypgen::exact {
namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

std::size_t bytes_of(const UpperPoint& point) {
  return sizeof(UpperPoint) + point.belief.states.size() * (sizeof(int) + 2 * sizeof(double)) +
         point.base.size() * sizeof(double);
}

// The same belief with its likely states first: they limit how much of it another belief holds.
ClassBelief likely_first(const ClassBelief& belief) {
  std::vector<std::size_t> order(belief.states.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return belief.probabilities[a] > belief.probabilities[b];
  });
  ClassBelief sorted;
  for (const std::size_t i : order) {
    sorted.states.push_back(belief.states[i]);
    sorted.probabilities.push_back(belief.probabilities[i]);
  }
  return sorted;
}

}  // namespace

std::vector<double> Sawtooth::base(const ClassBelief& belief) const {
  std::vector<double> sums(width_, 0.0);
  for (std::size_t i = 0; i < belief.states.size(); ++i) {
    const double* row = vectors_.data() + index(belief.states[i]) * width_;
    for (std::size_t a = 0; a < width_; ++a) sums[a] += belief.probabilities[i] * row[a];
  }
  return sums;
}

double Sawtooth::largest(const std::vector<double>& base) {
  return base.empty() ? 0.0 : *std::max_element(base.begin(), base.end());
}

void Sawtooth::lower(const ClassBelief& belief, const std::vector<double>& base, double value,
                     std::uint64_t number, int& at) {
  if (at < 0) {
    at = static_cast<int>(points_.size());
    points_.emplace_back();
    bytes_ += bytes_of(points_.back());
  }
  UpperPoint& point = points_[index(at)];
  if (point.belief.states.empty()) {
    bytes_ -= bytes_of(point);
    point.belief = likely_first(belief);
    for (const double probability : point.belief.probabilities) point.inverse.push_back(1.0 / probability);
    point.base = base;
    bytes_ += bytes_of(point);
  } else {
    order_.erase(std::find(order_.begin(), order_.end(), at));
  }
  point.value = value;
  point.number = number;
  point.likely_state = point.belief.states[0];
  point.likely_inverse = point.inverse[0];
  point.largest_drop = largest(base) - value;
  order_.push_back(at);
}

void Sawtooth::lower_convex(const std::vector<double>& vectors) {
  for (std::size_t i = 0; i < vectors_.size(); ++i) vectors_[i] = std::min(vectors_[i], vectors[i]);
  for (const int at : order_) {
    UpperPoint& point = points_[index(at)];
    point.base = base(point.belief);
    point.largest_drop = largest(point.base) - point.value;
  }
}

void Sawtooth::scatter(const ClassBelief& belief) const {
  for (std::size_t i = 0; i < belief.states.size(); ++i) {
    scattered_[index(belief.states[i])] = belief.probabilities[i];
  }
}

void Sawtooth::clear(const ClassBelief& belief) const {
  for (const int state : belief.states) scattered_[index(state)] = 0.0;
}

// The bound at the scattered belief by one point, or `value` if that is less.
double Sawtooth::through(const UpperPoint& point, const std::vector<double>& base, std::size_t top,
                         double value) const {
  const double most = scattered_[index(point.likely_state)] * point.likely_inverse * point.largest_drop;
  if (most <= base[top] - value) return value;
  const double drop = point.base[top] - point.value;
  // By convexity no share that is smaller than this one lowers `value`.
  const double least = drop > 0.0 ? (base[top] - value) / drop : 1.0;
  double share = 1.0;
  for (std::size_t i = 0; i < point.inverse.size() && share > least; ++i) {
    share = std::min(share, scattered_[index(point.belief.states[i])] * point.inverse[i]);
  }
  if (share <= least) return value;
  double rest = base[0] - share * point.base[0];
  for (std::size_t a = 1; a < width_; ++a) rest = std::max(rest, base[a] - share * point.base[a]);
  return std::min(value, share * point.value + rest);
}

double Sawtooth::lowest(const ClassBelief& belief, const std::vector<double>& base, std::uint64_t from,
                        double value) const {
  if (order_.empty() || points_[index(order_.back())].number < from) return value;
  const auto top = static_cast<std::size_t>(std::max_element(base.begin(), base.end()) - base.begin());
  scatter(belief);
  for (auto at = order_.rbegin(); at != order_.rend() && points_[index(*at)].number >= from; ++at) {
    value = through(points_[index(*at)], base, top, value);
  }
  clear(belief);
  return value;
}

double Sawtooth::lowest_but(int skipped, const ClassBelief& belief, const std::vector<double>& base,
                            double value) const {
  const auto top = static_cast<std::size_t>(std::max_element(base.begin(), base.end()) - base.begin());
  scatter(belief);
  for (const int at : order_) {
    if (at != skipped) value = through(points_[index(at)], base, top, value);
  }
  clear(belief);
  return value;
}

void Sawtooth::prune() {
  if (order_.size() < prune_at_) return;
  const std::vector<int> candidates = order_;
  for (const int at : candidates) {
    UpperPoint& point = points_[index(at)];
    if (lowest_but(at, point.belief, point.base, largest(point.base)) > point.value) continue;
    order_.erase(std::find(order_.begin(), order_.end(), at));
    bytes_ -= bytes_of(point);
    point = UpperPoint();
    bytes_ += bytes_of(point);
  }
  prune_at_ = std::max(prune_at_, 2 * order_.size());
}

}  // namespace hypgen::exact
