// SPDX-License-Identifier: Apache-2.0
#include "mixture.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <utility>

namespace hypgen::exact {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A part is cheaper if it is by more than this share of what costs differ by.
constexpr double kCheaper = 1e-10;
// Directions of less are rounding.
constexpr double kFlat = 1e-11;
// A mixture may be negative by as much, which is rounding.
constexpr double kNegative = 1e-10;
constexpr int kMostPivots = 100;

template <class Vector>
auto at(Vector& vector, Index i) -> decltype(vector[0]) {
  return vector[static_cast<std::size_t>(i)];
}

// The basis is the points of the mixture and the corners of all rows but the mixture's.
class Program {
 public:
  Program(const PricedPoints& points, const ClassBelief& belief, const std::vector<double>& corners);

  // False if the mixture is none of the belief.
  bool start(const Mixture& mixture);
  // False once nothing is cheaper.
  bool pivot();
  Mixture mixture() const;

 private:
  static constexpr Index kNone = -1;
  struct Entering {
    Index point = kNone;
    Index corner = kNone;
  };

  double corner_cost(Index row) const { return at(corners_, row) - least_; }
  VectorXd column(Index point) const;
  bool solve();
  Entering cheaper() const;
  VectorXd of_rows(const VectorXd& column) const;

  const PricedPoints& points_;
  const ClassBelief& belief_;
  const std::vector<double>& corners_;
  VectorXd target_;
  VectorXd outside_;  // each point's mass outside the belief's states; empty where these are all states
  double least_ = 0.0;
  double enough_ = 0.0;
  std::vector<Index> chosen_;  // points
  std::vector<Index> rows_;
  std::vector<char> is_free_;              // whether the row is one of them
  MatrixXd columns_;                       // of the chosen points
  Eigen::PartialPivLU<MatrixXd> factors_;  // of the columns' rows
  VectorXd weights_;                       // of the chosen points
  VectorXd rest_;                          // of the corners, 0 in the mixture's rows but for rounding
};

Program::Program(const PricedPoints& points, const ClassBelief& belief, const std::vector<double>& corners)
    : points_(points), belief_(belief), corners_(corners) {
  const auto rows = static_cast<Index>(corners.size());
  target_ = Eigen::Map<const VectorXd>(belief.probabilities.data(), rows);
  if (rows < points.beliefs.rows()) {
    VectorXd outside = VectorXd::Ones(points.beliefs.rows());
    for (const int state : belief.states) outside[state] = 0.0;
    outside_ = points.beliefs.transpose() * outside;
  }
  // All parts have mass 1, so a constant in all costs changes nothing.
  const auto [low, high] = std::minmax_element(corners.begin(), corners.end());
  least_ = *low;
  double most = *high;
  if (points.costs.size() > 0) {
    least_ = std::min(least_, points.costs.minCoeff());
    most = std::max(most, points.costs.maxCoeff());
  }
  enough_ = kCheaper * (most - least_);
}

VectorXd Program::column(Index point) const {
  VectorXd found(target_.size());
  for (Index i = 0; i < found.size(); ++i) found[i] = points_.beliefs(at(belief_.states, i), point);
  return found;
}

VectorXd Program::of_rows(const VectorXd& column) const {
  VectorXd found(static_cast<Index>(rows_.size()));
  for (Index i = 0; i < found.size(); ++i) found[i] = column[at(rows_, i)];
  return found;
}

// Factors the basis and finds its weights.
bool Program::solve() {
  const auto size = static_cast<Index>(chosen_.size());
  is_free_.assign(static_cast<std::size_t>(target_.size()), 0);
  for (const Index row : rows_) at(is_free_, row) = 1;
  columns_.resize(target_.size(), size);
  for (Index i = 0; i < size; ++i) columns_.col(i) = column(at(chosen_, i));
  weights_.resize(size);
  rest_ = target_;
  if (size == 0) return true;
  MatrixXd square(size, size);
  for (Index i = 0; i < size; ++i) square.row(i) = columns_.row(at(rows_, i));
  factors_.compute(square);
  weights_ = factors_.solve(of_rows(target_));
  weights_ += factors_.solve(VectorXd(of_rows(target_) - square * weights_));
  rest_ = target_ - columns_ * weights_;
  return weights_.allFinite() && weights_.minCoeff() >= -kNegative && rest_.minCoeff() >= -kNegative;
}

bool Program::start(const Mixture& mixture) {
  chosen_.assign(mixture.points.begin(), mixture.points.end());
  rows_.assign(mixture.rows.begin(), mixture.rows.end());
  return solve();
}

// The part that saves most for each unit of it.
Program::Entering Program::cheaper() const {
  VectorXd prices(target_.size());
  for (Index i = 0; i < prices.size(); ++i) prices[i] = at(is_free_, i) != 0 ? 0.0 : corner_cost(i);
  if (!chosen_.empty()) {
    VectorXd costs(static_cast<Index>(chosen_.size()));
    for (Index i = 0; i < costs.size(); ++i) costs[i] = points_.costs[at(chosen_, i)] - least_;
    const VectorXd free = factors_.transpose().solve(VectorXd(costs - columns_.transpose() * prices));
    for (Index i = 0; i < free.size(); ++i) prices[at(rows_, i)] = free[i];
  }
  Entering found;
  double best = -enough_;
  for (const Index row : rows_) {
    const double saved = corner_cost(row) - prices[row];
    if (saved >= best) continue;
    best = saved;
    found.corner = row;
  }
  if (points_.costs.size() == 0) return found;
  VectorXd of_state = VectorXd::Zero(points_.beliefs.rows());
  for (Index i = 0; i < prices.size(); ++i) of_state[at(belief_.states, i)] = prices[i];
  const VectorXd worth = points_.beliefs.transpose() * of_state;
  for (Index point = 0; point < worth.size(); ++point) {
    const double saved = points_.costs[point] - least_ - worth[point];
    if (saved >= best || (outside_.size() > 0 && outside_[point] > 0.0)) continue;
    best = saved;
    found = {point, kNone};
  }
  return found;
}

bool Program::pivot() {
  const Entering entering = cheaper();
  if (entering.point == kNone && entering.corner == kNone) return false;
  VectorXd added =
      entering.point == kNone ? VectorXd(VectorXd::Zero(target_.size())) : column(entering.point);
  if (entering.point == kNone) added[entering.corner] = 1.0;
  VectorXd direction(static_cast<Index>(chosen_.size()));
  if (!chosen_.empty()) {
    direction = factors_.solve(of_rows(added));
    added -= columns_ * direction;
  }
  Index point = kNone;
  Index corner = kNone;
  double share = kInfinity;
  for (Index i = 0; i < direction.size(); ++i) {
    if (direction[i] <= kFlat || std::max(weights_[i], 0.0) / direction[i] >= share) continue;
    share = std::max(weights_[i], 0.0) / direction[i];
    point = i;
  }
  for (Index i = 0; i < added.size(); ++i) {
    if (at(is_free_, i) != 0 || added[i] <= kFlat || std::max(rest_[i], 0.0) / added[i] >= share) continue;
    share = std::max(rest_[i], 0.0) / added[i];
    corner = i;
  }
  if (point == kNone && corner == kNone) return false;
  const std::vector<Index> chosen = chosen_;
  const std::vector<Index> rows = rows_;
  if (corner != kNone) rows_.push_back(corner);
  if (corner == kNone) chosen_.erase(chosen_.begin() + point);
  if (entering.point != kNone) chosen_.push_back(entering.point);
  if (entering.corner != kNone) rows_.erase(std::find(rows_.begin(), rows_.end(), entering.corner));
  if (solve()) return true;
  chosen_ = chosen;
  rows_ = rows;
  solve();
  return false;
}

Mixture Program::mixture() const {
  Mixture found{{chosen_.begin(), chosen_.end()}, {rows_.begin(), rows_.end()}, {}};
  const VectorXd weights = weights_.cwiseMax(0.0);
  const VectorXd mass = columns_ * weights;
  double scale = 1.0;
  for (Index i = 0; i < mass.size(); ++i) {
    const double most = target_[i] + std::numeric_limits<double>::epsilon();
    if (mass[i] > most) scale = std::min(scale, most / mass[i]);
  }
  for (const double weight : weights) found.weights.push_back(scale * weight);
  return found;
}

}  // namespace

Mixture cheapest_mixture(const PricedPoints& points, const ClassBelief& belief,
                         const std::vector<double>& corners, Mixture mixture) {
  Program program(points, belief, corners);
  if (!program.start(mixture)) program.start({});
  for (int pivots = 0; pivots < kMostPivots && program.pivot(); ++pivots) {
  }
  return program.mixture();
}

}  // namespace hypgen::exact
