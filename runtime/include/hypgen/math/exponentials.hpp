// SPDX-License-Identifier: Apache-2.0
// Square roots, exponentials, logarithms and powers: the same bits on every host and device.
//
// Computed in double by a fixed sequence of IEEE + - * /, sqrt and floor, with exponents taken apart and put
// together through bits, and rounded once to float. `hypgen.dsl.float_math` is the same sequence.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "hypgen/core/config.hpp"
#include "hypgen/math/float_bits.hpp"

namespace hypgen::math {

namespace detail {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A positive finite double as mantissa * 2^exponent with the mantissa in (sqrt(1/2), sqrt(2)].
struct Split {
  double mantissa;
  double exponent;
};

HYPGEN_FN Split split(double x) {
  const std::uint64_t bits = to_bits(x);
  double exponent = static_cast<double>(static_cast<std::int64_t>(bits >> 52) - 1023);
  double mantissa = from_bits((bits & 0x000FFFFFFFFFFFFFU) | 0x3FF0000000000000U);
  if (mantissa > 1.4142135623730951) {
    mantissa = mantissa * 0.5;
    exponent = exponent + 1.0;
  }
  return {mantissa, exponent};
}

/// atanh(z) / z for |z| <= 0.1716, by its series up to z^20: log(m) = 2 atanh((m - 1) / (m + 1)).
template <class T>
HYPGEN_FN T atanh_over(T z) {
  const T s = z * z;
  T sum = 1.0 / 21.0 * s + 1.0 / 19.0;
  sum = sum * s + 1.0 / 17.0;
  sum = sum * s + 1.0 / 15.0;
  sum = sum * s + 1.0 / 13.0;
  sum = sum * s + 1.0 / 11.0;
  sum = sum * s + 1.0 / 9.0;
  sum = sum * s + 1.0 / 7.0;
  sum = sum * s + 1.0 / 5.0;
  sum = sum * s + 1.0 / 3.0;
  return sum * s + 1.0;
}

/// scale * log(x) as exponent * per_octave + the mantissa's part; x is no subnormal double.
HYPGEN_FN double scaled_log(double x, double per_octave, double scale) {
  if (x != x || x < 0.0) return kNaN;
  if (x == 0.0) return -kInfinity;
  if (x == kInfinity) return kInfinity;
  const Split parts = split(x);
  const double z = (parts.mantissa - 1.0) / (parts.mantissa + 1.0);
  return parts.exponent * per_octave + (z * atanh_over(z)) * scale;
}

HYPGEN_FN double log(double x) { return scaled_log(x, 0.6931471805599453, 2.0); }

HYPGEN_FN double log2(double x) { return scaled_log(x, 1.0, 2.8853900817779268); }  // 2 / ln 2

/// e^t for |t| <= ln 2 / 2, by its Taylor series.
template <class T>
HYPGEN_FN T exp_series(T t) {
  T sum = 1.0 / 6227020800.0 * t + 1.0 / 479001600.0;
  sum = sum * t + 1.0 / 39916800.0;
  sum = sum * t + 1.0 / 3628800.0;
  sum = sum * t + 1.0 / 362880.0;
  sum = sum * t + 1.0 / 40320.0;
  sum = sum * t + 1.0 / 5040.0;
  sum = sum * t + 1.0 / 720.0;
  sum = sum * t + 1.0 / 120.0;
  sum = sum * t + 1.0 / 24.0;
  sum = sum * t + 1.0 / 6.0;
  sum = sum * t + 0.5;
  sum = sum * t + 1.0;
  return sum * t + 1.0;
}

/// 2^y for |y| <= 1000: e^t, t = (y - n) ln 2, times 2^n for the nearest integer n.
HYPGEN_FN double exp2_inside(double y) {
  const double n = std::floor(y + 0.5);
  const double t = (y - n) * 0.6931471805599453;
  return exp_series(t) * from_bits(static_cast<std::uint64_t>(static_cast<std::int64_t>(n) + 1023) << 52);
}

/// 2^y for a float. Beyond +-200 every result is 0 or infinite as a float, so y is cut there.
HYPGEN_FN double exp2(double y) {
  if (y != y) return kNaN;
  if (y > 200.0) return kInfinity;
  if (y < -200.0) return 0.0;
  return exp2_inside(y);
}

}  // namespace detail

HYPGEN_FN float sqrt(float x) { return std::sqrt(x); }

HYPGEN_FN float log2(float x) { return static_cast<float>(detail::log2(static_cast<double>(x))); }

HYPGEN_FN float log(float x) { return static_cast<float>(detail::log(static_cast<double>(x))); }

HYPGEN_FN float exp2(float x) { return static_cast<float>(detail::exp2(static_cast<double>(x))); }

HYPGEN_FN float exp(float x) {
  return static_cast<float>(detail::exp2(static_cast<double>(x) * 1.4426950408889634));
}

HYPGEN_FN float hypot(float a, float b) {
  const double x = static_cast<double>(a);
  const double y = static_cast<double>(b);
  return static_cast<float>(std::sqrt(x * x + y * y));
}

/// a^b with C's rules for zeros, infinities and negative bases.
HYPGEN_FN float pow(float a, float b) {
  if (b == 0.0F || a == 1.0F) return 1.0F;
  const double x = static_cast<double>(a);
  const double y = static_cast<double>(b);
  const double size = x < 0.0 ? -x : x;
  const bool whole = std::floor(y) == y;
  const bool odd = whole && std::floor(y * 0.5) != y * 0.5;
  if (y != y || (x < 0.0 && size < detail::kInfinity && !whole)) return static_cast<float>(detail::kNaN);
  const double power = size == 1.0 ? 1.0 : detail::exp2(y * detail::log2(size));
  return static_cast<float>(odd && (to_bits(a) >> 31) != 0 ? -power : power);
}

}  // namespace hypgen::math
