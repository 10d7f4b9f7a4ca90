// The scalar functions of generated models: the same bits on every host and device.
//
// Float functions are computed in double by a fixed sequence of IEEE + - * /, sqrt and floor, with exponents
// taken apart and put together through bits, and rounded once to float. That leaves about 20 bits to spare:
// results are correctly rounded but for a few inputs in a million, and never more than one unit in the last
// place away. `hypgen.dsl.float_math` is the same sequence in numpy, operation by operation; change both or
// neither. Compile with -ffp-contract=off (--fmad=false): a fused multiply-add changes the results.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "hypgen/config.hpp"

namespace hypgen::math {

static_assert(std::numeric_limits<float>::is_iec559 && std::numeric_limits<double>::is_iec559);

/// Fraction bits of a reward in fixed point.
inline constexpr int kFixedBits = 24;

// Bits ---------------------------------------------------------------------------------------------------

HYPGEN_FN std::uint32_t to_bits(float x) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  return bits;
}

HYPGEN_FN std::uint64_t to_bits(double x) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  return bits;
}

HYPGEN_FN float from_bits(std::uint32_t bits) {
  float x;
  std::memcpy(&x, &bits, sizeof x);
  return x;
}

HYPGEN_FN double from_bits(std::uint64_t bits) {
  double x = 0.0;
  std::memcpy(&x, &bits, sizeof x);
  return x;
}

/// The bits of a float for comparison: every NaN gives the same ones.
HYPGEN_FN std::uint32_t canonical_bits(float x) { return x != x ? 0x7FC00000U : to_bits(x); }

// Floats -------------------------------------------------------------------------------------------------

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
HYPGEN_FN double atanh_over(double z) {
  const double s = z * z;
  double sum = 1.0 / 21.0;
  sum = sum * s + 1.0 / 19.0;
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

/// scale * log(x) as exponent * per_octave + the mantissa's part; x is a float's value.
HYPGEN_FN double scaled_log(double x, double per_octave, double scale) {
  if (x != x || x < 0.0) return kNaN;
  if (x == 0.0) return -kInfinity;
  if (x == kInfinity) return kInfinity;
  const Split parts = split(x);
  const double z = (parts.mantissa - 1.0) / (parts.mantissa + 1.0);
  return parts.exponent * per_octave + (z * atanh_over(z)) * scale;
}

HYPGEN_FN double log2(double x) { return scaled_log(x, 1.0, 2.8853900817779268); }  // 2 / ln 2

/// 2^y: the Taylor series of e^t, t = (y - n) ln 2, times 2^n for the nearest integer n.
/// Beyond +-200 every result is 0 or infinite as a float, so y is cut there.
HYPGEN_FN double exp2(double y) {
  if (y != y) return kNaN;
  if (y > 200.0) return kInfinity;
  if (y < -200.0) return 0.0;
  const double n = std::floor(y + 0.5);
  const double t = (y - n) * 0.6931471805599453;
  double sum = 1.0 / 6227020800.0;
  sum = sum * t + 1.0 / 479001600.0;
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
  sum = sum * t + 1.0;
  return sum * from_bits(static_cast<std::uint64_t>(static_cast<std::int64_t>(n) + 1023) << 52);
}

}  // namespace detail

HYPGEN_FN float sqrt(float x) { return std::sqrt(x); }

HYPGEN_FN float log2(float x) { return static_cast<float>(detail::log2(static_cast<double>(x))); }

HYPGEN_FN float log(float x) {
  return static_cast<float>(detail::scaled_log(static_cast<double>(x), 0.6931471805599453, 2.0));
}

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

// Numbers of either kind ---------------------------------------------------------------------------------

/// `b < a ? b : a`.
template <class T>
HYPGEN_FN T min(T a, T b) {
  return b < a ? b : a;
}

/// `a < b ? b : a`.
template <class T>
HYPGEN_FN T max(T a, T b) {
  return a < b ? b : a;
}

/// x forced into [low, high]; NaN stays NaN.
template <class T>
HYPGEN_FN T clamp(T x, T low, T high) {
  return x < low ? low : (high < x ? high : x);
}

/// -1, 0 or 1; 0 for NaN.
template <class T>
HYPGEN_FN T sign(T x) {
  return x > T{0} ? T{1} : (x < T{0} ? T{-1} : T{0});
}

HYPGEN_FN std::int32_t abs(std::int32_t x) { return x < 0 ? -x : x; }

HYPGEN_FN float abs(float x) { return std::fabs(x); }

/// Whether x is NaN: a model error wherever a reward, a bound or a weight has one.
HYPGEN_FN bool is_nan(float x) { return x != x; }

// Integers -----------------------------------------------------------------------------------------------

/// The quotient rounded down; 0 for a zero divisor.
HYPGEN_FN std::int32_t floordiv(std::int32_t a, std::int32_t b) {
  if (b == 0) return 0;
  const std::int64_t x = a;  // widened: the lowest int32 divided by -1 traps
  const std::int64_t quotient = x / b;
  const bool inexact = quotient * b != x;
  return static_cast<std::int32_t>(quotient - (inexact && (a < 0) != (b < 0) ? 1 : 0));
}

/// a - b * floordiv(a, b), which has the divisor's sign; 0 for a zero divisor.
HYPGEN_FN std::int32_t mod(std::int32_t a, std::int32_t b) {
  if (b == 0) return 0;
  const std::int64_t rest = std::int64_t{a} % b;
  return static_cast<std::int32_t>(rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest);
}

namespace detail {

HYPGEN_FN std::int32_t saturate(double whole, std::int32_t low, std::int32_t high) {
  if (!(whole > static_cast<double>(low))) return low;  // NaN too
  return whole < static_cast<double>(high) ? static_cast<std::int32_t>(whole) : high;
}

}  // namespace detail

/// floor(x), ceil(x) and x rounded half to even, saturated to [low, high]; NaN gives low.
HYPGEN_FN std::int32_t floor_to_int(float x, std::int32_t low, std::int32_t high) {
  return detail::saturate(std::floor(static_cast<double>(x)), low, high);
}

HYPGEN_FN std::int32_t ceil_to_int(float x, std::int32_t low, std::int32_t high) {
  return detail::saturate(std::ceil(static_cast<double>(x)), low, high);
}

HYPGEN_FN std::int32_t round_to_int(float x, std::int32_t low, std::int32_t high) {
  return detail::saturate(std::rint(static_cast<double>(x)), low, high);
}

// Fixed point and thresholds -----------------------------------------------------------------------------

/// Where rewards in fixed point saturate: terms of either kind, and a step's sum.
inline constexpr std::int64_t kFixedLimit = std::int64_t{1} << 48;

HYPGEN_FN std::int64_t saturate_fixed(std::int64_t x) { return clamp(x, -kFixedLimit, kFixedLimit); }

/// A float reward term in fixed point: half to even, saturated, 0 for NaN.
HYPGEN_FN std::int64_t to_fixed(float x) {
  const double scaled = std::rint(static_cast<double>(x) * 16777216.0);
  if (scaled != scaled) return 0;
  constexpr double kLimit = static_cast<double>(kFixedLimit);
  return static_cast<std::int64_t>(clamp(scaled, -kLimit, kLimit));
}

/// An int reward term in fixed point.
HYPGEN_FN std::int64_t to_fixed(std::int32_t x) {
  return saturate_fixed(std::int64_t{x} * (std::int64_t{1} << kFixedBits));
}

HYPGEN_FN float from_fixed(std::int64_t x) {
  return static_cast<float>(static_cast<double>(x) * 5.9604644775390625e-08);
}

/// T(p): a uniform 32-bit word is below it with probability p. In [0, 2^32]; 0 for NaN.
HYPGEN_FN std::uint64_t threshold(float p) {
  const double scaled = static_cast<double>(p) * 4294967296.0;
  if (!(scaled > 0.0)) return 0;
  return scaled < 4294967296.0 ? static_cast<std::uint64_t>(scaled) : std::uint64_t{4294967296};
}

}  // namespace hypgen::math
