// SPDX-License-Identifier: Apache-2.0
// Trigonometric functions of floats: the same bits on every host and device.
//
// Computed in double by fixed sequences of IEEE + - * /, sqrt and floor and rounded once to float, like
// exponentials.hpp. `hypgen.dsl.float_trigonometry` is the same sequence, operation by operation.
#pragma once

#include <cmath>
#include <cstdint>

#include "hypgen/core/config.hpp"
#include "hypgen/math/exponentials.hpp"
#include "hypgen/math/float_bits.hpp"

namespace hypgen::math {

namespace detail {

/// An angle as quadrant * pi/2 + rest with |rest| <= pi/4 (a little more where rounding decides); quadrant
/// counts modulo 4.
struct Angle {
  double rest;
  int quadrant;
};

/// Reduces 0 <= x <= 2^20: pi/2 is split into 33 + 33 + 53 bits, so that the first two products and the first
/// difference are exact.
HYPGEN_FN Angle reduce_small(double x) {
  const double n = std::floor(x * 0.6366197723675814 + 0.5);
  const double rest = ((x - n * 1.5707963267341256) - n * 6.077100506303966e-11) - n * 2.0222662487959506e-21;
  return {rest, static_cast<int>(n) & 3};
}

/// Reduces a float x >= 2^20 by integers (Payne and Hanek): x = m 2^e with a 24-bit m, and of x * 2/pi only
/// the 96 bits of 2/pi from weight 2^(2 - e) downwards count modulo 4. What is cut off is below 2^-70.
HYPGEN_FN Angle reduce_large(double x) {
  static constexpr std::uint32_t kTwoOverPi[8] = {0,           0xA2F9836EU, 0x4E441529U, 0xFC2757D1U,
                                                  0xF534DDC0U, 0xDB629599U, 0x3C439041U, 0xFE5163ABU};
  constexpr std::uint64_t kLow = 0xFFFFFFFFU;
  const std::uint64_t bits = to_bits(x);
  const std::uint64_t m = ((bits >> 29) & 0x7FFFFFU) | 0x800000U;
  const int start =
      static_cast<int>(bits >> 52) - 1046 + 30;  // of the bits of 2/pi, counted from the table's first
  const int word = start >> 5;
  const int shift = 32 - (start & 31);
  std::uint64_t part[3] = {0, 0, 0};
  for (int i = 0; i < 3; ++i) {
    const std::uint64_t pair = (std::uint64_t{kTwoOverPi[word + i]} << 32) | kTwoOverPi[word + i + 1];
    part[i] = m * ((pair >> shift) & kLow);
  }
  part[1] += part[2] >> 32;
  part[0] += part[1] >> 32;
  const std::uint64_t top = (part[0] << 32) | (part[1] & kLow);  // two bits of quadrant, then the fraction
  const std::uint64_t quadrant = (top + (std::uint64_t{1} << 61)) >> 62;
  const std::int64_t high = static_cast<std::int64_t>(top - (quadrant << 62));
  const double fraction = static_cast<double>(high) * 2.168404344971009e-19 +  // 2^-62, then 2^-94
                          static_cast<double>(part[2] & kLow) * 5.048709793414476e-29;
  return {fraction * 1.5707963267948966, static_cast<int>(quadrant)};
}

HYPGEN_FN Angle reduce(double x) { return x <= 1048576.0 ? reduce_small(x) : reduce_large(x); }

/// sin by its Taylor series up to r^17, which errs by less than 2^-60 for |r| <= pi/4.
template <class T>
HYPGEN_FN T sin_near(T r) {
  const T s = r * r;
  T sum = 1.0 / 355687428096000.0 * s - 1.0 / 1307674368000.0;
  sum = sum * s + 1.0 / 6227020800.0;
  sum = sum * s - 1.0 / 39916800.0;
  sum = sum * s + 1.0 / 362880.0;
  sum = sum * s - 1.0 / 5040.0;
  sum = sum * s + 1.0 / 120.0;
  sum = sum * s - 1.0 / 6.0;
  return r + r * (sum * s);
}

/// cos by its Taylor series up to r^16, which errs by less than 2^-58 for |r| <= pi/4.
template <class T>
HYPGEN_FN T cos_near(T r) {
  const T s = r * r;
  T sum = 1.0 / 20922789888000.0 * s - 1.0 / 87178291200.0;
  sum = sum * s + 1.0 / 479001600.0;
  sum = sum * s - 1.0 / 3628800.0;
  sum = sum * s + 1.0 / 40320.0;
  sum = sum * s - 1.0 / 720.0;
  sum = sum * s + 1.0 / 24.0;
  sum = sum * s - 0.5;
  return sum * s + 1.0;
}

/// atan for |u| <= 1/16, by its series up to u^15.
template <class T>
HYPGEN_FN T atan_series(T u) {
  const T s = u * u;
  T sum = -1.0 / 15.0 * s + 1.0 / 13.0;
  sum = sum * s - 1.0 / 11.0;
  sum = sum * s + 1.0 / 9.0;
  sum = sum * s - 1.0 / 7.0;
  sum = sum * s + 1.0 / 5.0;
  sum = sum * s - 1.0 / 3.0;
  return u + u * (sum * s);
}

/// atan(k / 8) for k = 0 .. 8, of 16 entries.
HYPGEN_FN const double* eighths() {
  static constexpr double kEighths[16] = {0.0,
                                          0.12435499454676144,
                                          0.24497866312686414,
                                          0.35877067027057225,
                                          0.4636476090008061,
                                          0.5585993153435624,
                                          0.6435011087932844,
                                          0.7188299996216245,
                                          0.7853981633974483};
  return kEighths;
}

/// atan(a / b) for 0 <= a <= b, 0 < b: from the nearest atan(k / 8), atan(t) = atan(c) + atan((t - c) / (1 +
/// t c)).
HYPGEN_FN double atan_below_one(double a, double b) {
  const double k = std::floor(a / b * 8.0 + 0.5);
  const double c = k * 0.125;
  const double u = (a - c * b) / (b + c * a);
  return eighths()[static_cast<int>(k)] + atan_series(u);
}

/// The angle of the point (x, y) from the x axis, in [-pi, pi], with C's signs of zeros.
HYPGEN_FN double atan2(double y, double x) {
  if (x != x || y != y) return kNaN;
  double a = std::fabs(y);
  double b = std::fabs(x);
  const bool steep = a > b;
  if (steep) {
    const double swap = a;
    a = b;
    b = swap;
  }
  if (b == 0.0) b = 1.0;
  if (b == kInfinity) {
    a = a == kInfinity ? 1.0 : 0.0;
    b = 1.0;
  }
  double angle = atan_below_one(a, b);
  if (steep) angle = 1.5707963267948966 - angle;
  if ((to_bits(x) >> 63) != 0) angle = 3.141592653589793 - angle;
  return (to_bits(y) >> 63) != 0 ? -angle : angle;
}

}  // namespace detail

HYPGEN_FN float sin(float x) {
  const double size = std::fabs(static_cast<double>(x));
  if (!(size < detail::kInfinity)) return static_cast<float>(detail::kNaN);
  const detail::Angle angle = detail::reduce(size);
  const double value =
      (angle.quadrant & 1) != 0 ? detail::cos_near(angle.rest) : detail::sin_near(angle.rest);
  const bool negative = ((angle.quadrant & 2) != 0) != ((to_bits(x) >> 31) != 0);
  return static_cast<float>(negative ? -value : value);
}

HYPGEN_FN float cos(float x) {
  const double size = std::fabs(static_cast<double>(x));
  if (!(size < detail::kInfinity)) return static_cast<float>(detail::kNaN);
  const detail::Angle angle = detail::reduce(size);
  const double value =
      (angle.quadrant & 1) != 0 ? detail::sin_near(angle.rest) : detail::cos_near(angle.rest);
  const bool negative = ((angle.quadrant + 1) & 2) != 0;
  return static_cast<float>(negative ? -value : value);
}

HYPGEN_FN float tan(float x) {
  const double size = std::fabs(static_cast<double>(x));
  if (!(size < detail::kInfinity)) return static_cast<float>(detail::kNaN);
  const detail::Angle angle = detail::reduce(size);
  const double sine = detail::sin_near(angle.rest);
  const double cosine = detail::cos_near(angle.rest);
  const bool odd = (angle.quadrant & 1) != 0;
  const double value = odd ? cosine / sine : sine / cosine;
  return static_cast<float>(odd != ((to_bits(x) >> 31) != 0) ? -value : value);
}

/// The angle in [-pi/2, pi/2] whose sine is x; NaN beyond +-1.
HYPGEN_FN float asin(float x) {
  const double y = static_cast<double>(x);
  if (!(y >= -1.0 && y <= 1.0)) return static_cast<float>(detail::kNaN);
  return static_cast<float>(detail::atan2(y, std::sqrt((1.0 - y) * (1.0 + y))));
}

/// The angle in [0, pi] whose cosine is x; NaN beyond +-1.
HYPGEN_FN float acos(float x) {
  const double y = static_cast<double>(x);
  if (!(y >= -1.0 && y <= 1.0)) return static_cast<float>(detail::kNaN);
  return static_cast<float>(detail::atan2(std::sqrt((1.0 - y) * (1.0 + y)), y));
}

/// The angle of the point (x, y) from the x axis, in [-pi, pi], with C's rules for zeros, infinities and NaN.
HYPGEN_FN float atan2(float y, float x) {
  return static_cast<float>(detail::atan2(static_cast<double>(y), static_cast<double>(x)));
}

}  // namespace hypgen::math
