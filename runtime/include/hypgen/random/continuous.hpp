// SPDX-License-Identifier: Apache-2.0
// Continuous laws: a draw from one word, the probability below a value, the density of a value, and the bins of
// a range. A law without width has a point that it always draws.
#pragma once

#include <cmath>
#include <cstdint>

#include "hypgen/core/config.hpp"
#include "hypgen/math/normal.hpp"
#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/random/word_thresholds.hpp"

namespace hypgen::dist {

namespace detail {

/// 2^power; 0 where that is below the range of `exp2_inside`, or no number.
HYPGEN_FN double decay(double power) { return power >= -1000.0 ? math::detail::exp2_inside(power) : 0.0; }

}  // namespace detail

/// The density of a value of a law, per unit; the probability of the point of a law without width.
template <class Law>
HYPGEN_FN double density(const Law& law, float x) {
  if (law.is_point()) return x == law.point() ? 1.0 : 0.0;
  return law.spread(static_cast<double>(x));
}

/// A normal law. `kRecurs`: few parameters occur in a model, so that the same probabilities are asked for again.
template <bool kRecurs>
struct NormalLaw {
  float mean;
  float deviation;

  HYPGEN_FN float draw(std::uint32_t word) const {
    return mean + deviation * static_cast<float>(math::normal_of_word(word));
  }

  /// A draw near the quantile of the word: words in order give values in order.
  HYPGEN_FN float quantile(std::uint32_t word) const {
    const std::uint32_t rising = word < 0x80000000U ? word : word ^ 0x7FFFFFFFU;
    return mean + std::fabs(deviation) * static_cast<float>(math::normal_of_word(rising));
  }

  HYPGEN_FN double below(double x) const { return cdf(standard(x)); }

  /// The probability from `low` to `x`, computed in the smaller tail.
  HYPGEN_FN double between(float low, double x) const {
    const double a = standard(static_cast<double>(low));
    const double b = standard(x);
    return a > 0.0 ? cdf(-a) - cdf(-b) : cdf(b) - cdf(a);
  }

  /// The x with `p` between `low` and it.
  HYPGEN_FN float beyond(float low, double p) const {
    const double a = standard(static_cast<double>(low));
    const double tail = a > 0.0 ? cdf(-a) - p : cdf(a) + p;
    const float distance = std::fabs(deviation) * static_cast<float>(math::normal_quantile(tail));
    return a > 0.0 ? mean - distance : mean + distance;
  }

  HYPGEN_FN double above(double x) const { return cdf(-standard(x)); }

  HYPGEN_FN bool is_point() const { return !(std::fabs(deviation) > 0.0F); }
  HYPGEN_FN float point() const { return mean; }

  HYPGEN_FN double spread(double x) const {
    const double z = standard(x);
    const double peak = 0.3989422804014327;  // 1 / sqrt(2 pi)
    return detail::decay(z * z * -0.7213475204444817) * peak / std::fabs(static_cast<double>(deviation));
  }

  HYPGEN_FN double standard(double x) const {
    return (x - static_cast<double>(mean)) / std::fabs(static_cast<double>(deviation));
  }

 private:
  HYPGEN_FN static double cdf(double x) {
    return kRecurs ? math::recurring_normal_cdf(x) : math::normal_cdf(x);
  }
};

using Normal = NormalLaw<false>;
using RecurringNormal = NormalLaw<true>;

struct Uniform {
  float low;
  float high;

  HYPGEN_FN float draw(std::uint32_t word) const {
    return math::min(low + (high - low) * static_cast<float>(math::unit_of_word(word)), high);
  }

  HYPGEN_FN float quantile(std::uint32_t word) const { return draw(word); }

  HYPGEN_FN double below(double x) const {
    const double from = static_cast<double>(low);
    const double to = static_cast<double>(high);
    if (!(to > from)) return x > to ? 1.0 : 0.0;
    return math::clamp((x - from) / (to - from), 0.0, 1.0);
  }

  HYPGEN_FN double above(double x) const { return 1.0 - below(x); }

  HYPGEN_FN bool is_point() const { return !(high > low); }
  HYPGEN_FN float point() const { return high; }

  HYPGEN_FN double spread(double x) const {
    const double from = static_cast<double>(low);
    const double to = static_cast<double>(high);
    return x >= from && x <= to ? 1.0 / (to - from) : 0.0;
  }
};

class Exponential {
 public:
  HYPGEN_FN explicit Exponential(float mean) : mean_(mean > 0.0F ? mean : 0.0F) {}

  HYPGEN_FN float draw(std::uint32_t word) const {
    return mean_ * static_cast<float>(math::exponential_of_word(word));
  }

  HYPGEN_FN float quantile(std::uint32_t word) const { return draw(~word); }

  HYPGEN_FN double below(double x) const { return 1.0 - survival(x); }

  HYPGEN_FN double between(float low, double x) const {
    return survival(static_cast<double>(low)) - survival(x);
  }

  HYPGEN_FN float beyond(float low, double p) const {
    return mean_ * static_cast<float>(-math::detail::log(survival(static_cast<double>(low)) - p));
  }

  HYPGEN_FN double above(double x) const { return survival(x); }

  HYPGEN_FN bool is_point() const { return !(mean_ > 0.0F); }
  HYPGEN_FN float point() const { return 0.0F; }

  HYPGEN_FN double spread(double x) const {
    const double mean = static_cast<double>(mean_);
    return x >= 0.0 ? detail::decay(x / mean * -1.4426950408889634) / mean : 0.0;
  }

 private:
  HYPGEN_FN double survival(double x) const {
    if (!(x > 0.0)) return 1.0;
    if (!(mean_ > 0.0F)) return 0.0;
    const double power = x / static_cast<double>(mean_) * -1.4426950408889634;
    return math::detail::exp2_inside(power > -1000.0 ? power : -1000.0);
  }

  float mean_;
};

/// A law given that its value lies in [low, high].
template <class Law>
class Truncated {
 public:
  HYPGEN_FN Truncated(Law law, float low, float high)
      : law_(law), low_(low), high_(high), total_(law.between(low, static_cast<double>(high))) {}

  HYPGEN_FN float draw(std::uint32_t word) const {
    if (!(total_ > 0.0)) return nearer();
    const float x = law_.beyond(low_, math::unit_of_word(word) * total_);
    return x > low_ ? (high_ < x ? high_ : x) : low_;
  }

  HYPGEN_FN float quantile(std::uint32_t word) const { return draw(word); }

  HYPGEN_FN double below(double x) const {
    if (!(total_ > 0.0)) return x > static_cast<double>(nearer()) ? 1.0 : 0.0;
    if (!(x > static_cast<double>(low_))) return 0.0;
    return x < static_cast<double>(high_) ? law_.between(low_, x) / total_ : 1.0;
  }

  HYPGEN_FN double above(double x) const { return 1.0 - below(x); }

  HYPGEN_FN bool is_point() const { return !(total_ > 0.0) || law_.is_point(); }
  HYPGEN_FN float point() const { return total_ > 0.0 ? law_.point() : nearer(); }

  HYPGEN_FN double spread(double x) const {
    const bool inside = x >= static_cast<double>(low_) && x <= static_cast<double>(high_);
    return inside ? law_.spread(x) / total_ : 0.0;
  }

 private:
  HYPGEN_FN float nearer() const { return law_.point() < low_ ? low_ : high_; }

  Law law_;
  float low_;
  float high_;
  double total_;
};

/// The density of a value of a law that is clamped into [low, high]; the ends have probabilities.
template <class Law>
HYPGEN_FN double clamped_density(const Law& law, float low, float high, float x) {
  if (law.is_point() || !(low < high)) return x == math::clamp(law.point(), low, high) ? 1.0 : 0.0;
  if (x == low) return law.below(static_cast<double>(low));
  if (x == high) return law.above(static_cast<double>(high));
  return x > low && x < high ? law.spread(static_cast<double>(x)) : 0.0;
}

/// `count` bins of equal width over [low, high); the end bins take what lies outside.
template <class Law>
class Bins {
 public:
  HYPGEN_FN Bins(Law law, float low, float high, std::int32_t count)
      : law_(law),
        low_(static_cast<double>(low)),
        width_(high > low ? static_cast<double>(high) - static_cast<double>(low) : 0.0),
        count_(count) {}

  /// The first bin that the word does not pass: near the quantile's, so that few probabilities are computed.
  template <class Word>
  HYPGEN_FN std::int32_t draw(Word word) const {
    const double place = (static_cast<double>(law_.quantile(typical(word))) - low_) / width_;
    std::int32_t bin = math::detail::saturate(std::floor(place * count_), 0, count_ - 1);
    while (bin > 0 && word < up_to(bin - 1)) --bin;
    while (bin < count_ - 1 && word >= up_to(bin)) ++bin;
    return bin;
  }

  HYPGEN_FN double density(std::int32_t bin) const {
    const std::uint64_t before = bin == 0 ? 0 : up_to(bin - 1);
    const std::uint64_t after = up_to(bin);
    return after > before ? share(after - before) : 0.0;
  }

 private:
  /// How many words give at most this bin.
  HYPGEN_FN std::uint64_t up_to(std::int32_t bin) const {
    if (bin == count_ - 1) return kWords;
    return words_of(law_.below(low_ + width_ * (static_cast<double>(bin + 1) / static_cast<double>(count_))));
  }

  Law law_;
  double low_;
  double width_;
  std::int32_t count_;
};

}  // namespace hypgen::dist
