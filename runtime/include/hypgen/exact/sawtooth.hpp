// SPDX-License-Identifier: Apache-2.0
// The upper bound of a class of states: a convex bound that holds everywhere, lowered by points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "hypgen/exact/alpha_vectors.hpp"

namespace hypgen::exact {

// A belief at which the value is known to be at most `value`.
struct UpperPoint {
  std::uint64_t number = 0;  // of the last change, over all classes
  // The likeliest state, and the most by which the point is below the convex bound: most points are passed
  // over by these alone.
  int likely_state = 0;
  double likely_inverse = 0.0;
  double largest_drop = 0.0;
  ClassBelief belief;           // likely states first; empty once it was taken out
  std::vector<double> inverse;  // 1 / probability, of each state
  std::vector<double> base;     // the convex bound's vectors at the belief
  double value = 0.0;
};

// Sawtooth bound (Hauskrecht 2000; Smith & Simmons, UAI 2005) over a convex bound instead of over the
// corners: where a belief is c times a point and a rest, its value is at most c times the point's and the
// convex bound of the rest, since values are convex.
class Sawtooth {
 public:
  // The convex bound is the largest product with a vector; `vectors` has a row of `width` for each of the
  // `states`, with a vector for each legal action of the class: what the action is worth at most.
  Sawtooth(std::vector<double> vectors, std::size_t states, std::size_t width)
      : width_(width), vectors_(std::move(vectors)), scattered_(states, 0.0) {}

  // The convex bound's vectors at a belief.
  std::vector<double> base(const ClassBelief& belief) const;
  // The largest of them, 0 if there is none.
  static double largest(const std::vector<double>& base);

  // Adds the point, or lowers the one that was added for the same belief; `at` says which, -1 at first.
  void lower(const ClassBelief& belief, const std::vector<double>& base, double value, std::uint64_t number,
             int& at);
  // The least that points which are not older than `from` make of the bound `value`.
  double lowest(const ClassBelief& belief, const std::vector<double>& base, std::uint64_t from,
                double value) const;
  // Lowers the convex bound where `vectors` are lower, and what points keep of it.
  void lower_convex(const std::vector<double>& vectors);
  const std::vector<double>& vectors() const { return vectors_; }
  // Takes out points that others make superfluous, if there are twice as many as after the last time. A point
  // that is lowered afterwards comes back.
  void prune();

  std::size_t points() const { return order_.size(); }
  std::size_t bytes() const { return bytes_; }

 private:
  double lowest_but(int skipped, const ClassBelief& belief, const std::vector<double>& base,
                    double value) const;
  double through(const UpperPoint& point, const std::vector<double>& base, std::size_t top,
                 double value) const;
  void scatter(const ClassBelief& belief) const;
  void clear(const ClassBelief& belief) const;

  std::size_t width_;
  std::vector<double> vectors_;
  std::vector<UpperPoint> points_;
  std::vector<int> order_;                 // of points, by number
  mutable std::vector<double> scattered_;  // probabilities of all states; zeroes between calls
  std::size_t bytes_ = 0;
  std::size_t prune_at_ = 64;
};

}  // namespace hypgen::exact
