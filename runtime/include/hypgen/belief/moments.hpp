// SPDX-License-Identifier: Apache-2.0
// The arithmetic of beliefs that a policy keeps as the mean and the deviation of a float.
//
// After each step the law of the float is taken to be the normal law, or the beta law of a range, that has
// this mean and deviation (assumed density filtering). Expectations are sums over equally spaced points.
// `hypgen.dsl.interpret.evaluate.moments` is the same sequence of operations.
#pragma once

#include <cmath>
#include <cstdint>

#include "hypgen/core/config.hpp"
#include "hypgen/math/exponentials.hpp"
#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/random/fine_words.hpp"

namespace hypgen::moments {

constexpr int kPoints = 32;
constexpr int kMostSweeps = 4;

/// Weighted numbers, relative to the first of them so that little cancels.
struct Sums {
  double shift = 0.0;
  double total = 0.0;
  double first = 0.0;
  double second = 0.0;

  HYPGEN_FN void add(double weight, double mean, double variance = 0.0) {
    if (!(weight > 0.0)) return;
    if (!(total > 0.0)) shift = mean;
    const double distance = mean - shift;
    total += weight;
    first += weight * distance;
    second += weight * (distance * distance + variance);
  }

  HYPGEN_FN double mean() const { return total > 0.0 ? shift + first / total : 0.0; }

  HYPGEN_FN double deviation() const {
    if (!(total > 0.0)) return 0.0;
    const double middle = first / total;
    const double variance = second / total - middle * middle;
    return variance > 0.0 ? std::sqrt(variance) : 0.0;
  }
};

/// The law of a float that is known by mean and deviation.
struct Law {
  double mean = 0.0;
  double deviation = 0.0;
  bool ranged = false;  // a beta law of low .. high
  double low = 0.0;
  double high = 0.0;
  double below = 0.0;  // the exponents of the beta density
  double above = 0.0;
  double log_below = 0.0;  // of the mean's place in the range
  double log_above = 0.0;

  HYPGEN_FN Law(const float* kept) : mean(kept[0]), deviation(kept[1]) {}

  HYPGEN_FN Law(const float* kept, float from, float to) : Law(kept) {
    ranged = true;
    low = static_cast<double>(from);
    high = static_cast<double>(to);
    const double place = (mean - low) / (high - low);
    if (!(high > low && deviation > 0.0 && place > 0.0 && place < 1.0)) {
      deviation = 0.0;
      return;
    }
    const double width = deviation / (high - low);
    const double size = place * (1.0 - place) / (width * width) - 1.0;
    const double bounded = size > 0.001 ? size : 0.001;
    below = place * bounded - 1.0;
    above = (1.0 - place) * bounded - 1.0;
    log_below = math::detail::log(place);
    log_above = math::detail::log(1.0 - place);
  }

  /// Whether more than one value is possible.
  HYPGEN_FN bool is_spread() const { return deviation > 0.0; }

  /// The density at x over that at the mean; 0 at the ends of a range and beyond.
  HYPGEN_FN double density(float x) const {
    if (!is_spread()) return 1.0;
    if (!ranged) {
      const double z = (static_cast<double>(x) - mean) / deviation;
      return power_of_two(z * z * -0.7213475204444817);  // 1 / (2 ln 2)
    }
    const double place = (static_cast<double>(x) - low) / (high - low);
    const double rest = 1.0 - place;
    if (!(place > 0.0 && rest > 0.0)) return 0.0;
    const double lower = below * (math::detail::log(place) - log_below);
    const double upper = above * (math::detail::log(rest) - log_above);
    return power_of_two((lower + upper) * 1.4426950408889634);  // 1 / ln 2
  }

 private:
  HYPGEN_FN static double power_of_two(double y) {
    if (!(y >= -1000.0)) return 0.0;
    return math::detail::exp2_inside(y < 1000.0 ? y : 1000.0);
  }
};

/// The middles of equal parts of an interval, within the law's range.
struct Points {
  double left;
  double step;

  HYPGEN_FN Points(const Law& law, double center, double radius) {
    left = center - 6.0 * radius;
    double right = center + 6.0 * radius;
    if (law.ranged) {
      left = left < law.low ? law.low : left;
      right = right > law.high ? law.high : right;
    }
    step = (right - left) * (1.0 / kPoints);
  }

  HYPGEN_FN Points(const Law& law) : Points(law, law.mean, law.deviation) {}

  HYPGEN_FN float at(int k) const { return static_cast<float>(left + step * (k + 0.5)); }
};

/// What a law, or a law for each point, comes to: its parts are added one by one.
class Mixture {
 public:
  /// Parts that follow belong to the point x.
  HYPGEN_FN void at(float x, double weight) {
    x_ = static_cast<double>(x);
    weight_ = weight;
  }

  HYPGEN_FN void certain(float value, double share = 1.0) { add(share, static_cast<double>(value), 0.0); }

  HYPGEN_FN void normal(float mean, float deviation) {
    const double size = static_cast<double>(deviation);
    add(1.0, static_cast<double>(mean), size * size);
  }

  HYPGEN_FN void uniform(float low, float high) {
    const double end = static_cast<double>(high);
    const double width = high > low ? end - static_cast<double>(low) : 0.0;
    add(1.0, end - width * 0.5, width * width / 12.0);
  }

  HYPGEN_FN void exponential(float mean) {
    const double size = mean > 0.0F ? static_cast<double>(mean) : 0.0;
    add(1.0, size, size * size);
  }

  HYPGEN_FN void store(float* kept) const {
    kept[0] = static_cast<float>(sums_.mean());
    kept[1] = static_cast<float>(sums_.deviation());
  }

  /// Stores the same unless every point stays where it is.
  HYPGEN_FN void move(float* kept) const {
    if (!still_) store(kept);
  }

 private:
  HYPGEN_FN void add(double share, double mean, double variance) {
    const double weight = weight_ * share;
    if (weight > 0.0 && !(mean == x_ && variance == 0.0)) still_ = false;
    sums_.add(weight, mean, variance);
  }

  Sums sums_;
  double x_ = 0.0;
  double weight_ = 1.0;
  bool still_ = true;
};

/// The shares of a table's entries, which are shares of their masses.
class Shares {
 public:
  HYPGEN_FN double take(float probability) { return take(math::mass(probability)); }
  HYPGEN_FN double take(std::uint64_t mass) {
    const std::uint64_t before = until_;
    until_ = dist::up_to(before, mass);
    return dist::share_of(until_ - before);
  }

  HYPGEN_FN double rest() const { return dist::share_of(dist::kWhole - until_); }

 private:
  std::uint64_t until_ = 0;
};

/// Bayes' rule by adaptive quadrature (Naylor and Smith, 1982): where the posterior is narrower than the
/// points' distance, they are drawn together around it, up to three times.
class Update {
 public:
  HYPGEN_FN Update(const Law& law)
      : law_(law), points_(law), mean_(law.mean), deviation_(law.deviation), due_(law.is_spread()) {}

  HYPGEN_FN bool due() const { return due_; }
  HYPGEN_FN float point(int k) const { return points_.at(k); }

  HYPGEN_FN void take(float x, double likelihood) {
    if (taken_ == 0) first_ = likelihood;
    alike_ = alike_ && likelihood == first_;
    ++taken_;
    sums_.add(law_.density(x) * likelihood, static_cast<double>(x));
  }

  /// Ends a sweep over the points. What no point tells apart or explains leaves the law as it is.
  HYPGEN_FN void sweep() {
    ++sweeps_;
    due_ = false;
    if (alike_ || !(sums_.total > 0.0)) return;
    mean_ = sums_.mean();
    const double found = sums_.deviation();
    const double least = points_.step * 0.2886751345948129;  // of what lies evenly between two points
    deviation_ = found > least ? found : least;
    if (found >= points_.step || sweeps_ == kMostSweeps) return;
    const double half = points_.step * 0.5;
    points_ = Points(law_, mean_, found > half ? found : half);
    sums_ = Sums();
    due_ = true;
  }

  HYPGEN_FN void store(float* kept) const {
    kept[0] = static_cast<float>(mean_);
    kept[1] = static_cast<float>(deviation_);
  }

 private:
  Law law_;
  Points points_;
  Sums sums_;
  double mean_;
  double deviation_;
  double first_ = 0.0;
  int taken_ = 0;
  int sweeps_ = 0;
  bool alike_ = true;
  bool due_;
};

}  // namespace hypgen::moments
