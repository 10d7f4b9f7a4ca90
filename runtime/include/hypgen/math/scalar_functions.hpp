// SPDX-License-Identifier: Apache-2.0
// The scalar functions of generated models: the same bits on every host and device.
//
// Float functions (exponentials.hpp, trigonometry.hpp, normal.hpp) are computed in double by a fixed sequence
// of IEEE + - * /, sqrt and floor, with exponents taken apart and put together through bits, and rounded once
// to float. That leaves about 20 bits to spare: results are correctly rounded but for a few inputs in a
// million, and never more than one unit in the last place away. `hypgen.dsl.interpret.floats` has the same
// sequences in numpy, operation by operation: change both or neither. A fused multiply-add changes the
// results: compile with the flags of cmake/host_flags.txt and cmake/nvcc_flags.txt.
#pragma once

#include <cmath>
#include <cstdint>

#include "hypgen/core/config.hpp"
#include "hypgen/math/exponentials.hpp"
#include "hypgen/math/float_bits.hpp"
#include "hypgen/math/normal.hpp"
#include "hypgen/math/trigonometry.hpp"

namespace hypgen::math {

/// Fraction bits of a reward in fixed point, where the model does not say otherwise.
inline constexpr int kFixedBits = 24;

/// `0 - x`. g++ 12 takes that for `-x` where x comes of an integer, which is -0 in place of 0.
HYPGEN_FN float from_zero(float x) { return x == 0.0F ? 0.0F : 0.0F - x; }

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

// Fixed point, thresholds and masses ---------------------------------------------------------------------

/// Where rewards in fixed point saturate: terms of either kind, and a step's sum.
inline constexpr std::int64_t kFixedLimit = std::int64_t{1} << 48;

HYPGEN_FN std::int64_t saturate_fixed(std::int64_t x) { return clamp(x, -kFixedLimit, kFixedLimit); }

/// Whether a step's sum has left the range of rewards in fixed point.
HYPGEN_FN bool is_saturated(std::int64_t x) { return x >= kFixedLimit || x <= -kFixedLimit; }

/// 2^exponent.
HYPGEN_FN constexpr double power_of_two(int exponent) {
  double power = 1.0;
  for (int i = 0; i < exponent; ++i) power *= 2.0;
  for (int i = 0; i > exponent; --i) power *= 0.5;
  return power;
}

/// A float reward term in fixed point: half to even, saturated, 0 for NaN.
template <int kBits = kFixedBits>
HYPGEN_FN std::int64_t to_fixed(float x) {
  constexpr double kScale = power_of_two(kBits);
  const double scaled = std::rint(static_cast<double>(x) * kScale);
  if (scaled != scaled) return 0;
  constexpr double kLimit = static_cast<double>(kFixedLimit);
  return static_cast<std::int64_t>(clamp(scaled, -kLimit, kLimit));
}

/// An int reward term in fixed point, likewise.
template <int kBits = kFixedBits>
HYPGEN_FN std::int64_t to_fixed(std::int32_t x) {
  if constexpr (kBits >= 0 && kBits < 32) {
    return saturate_fixed(std::int64_t{x} * (std::int64_t{1} << kBits));
  } else {
    constexpr double kScale = power_of_two(kBits);
    constexpr double kLimit = static_cast<double>(kFixedLimit);
    return static_cast<std::int64_t>(clamp(std::rint(x * kScale), -kLimit, kLimit));
  }
}

template <int kBits = kFixedBits>
HYPGEN_FN float from_fixed(std::int64_t x) {
  constexpr double kUnit = power_of_two(-kBits);
  return static_cast<float>(static_cast<double>(x) * kUnit);
}

/// T(p): a uniform 32-bit word is below it with probability p. In [0, 2^32]; 0 for NaN.
HYPGEN_FN std::uint64_t threshold(float p) {
  const double scaled = static_cast<double>(p) * 4294967296.0;
  if (!(scaled > 0.0)) return 0;
  return scaled < 4294967296.0 ? static_cast<std::uint64_t>(scaled) : std::uint64_t{4294967296};
}

/// M(p): 63 random bits are below it with probability p. In [0, 2^63]; 0 for NaN.
HYPGEN_FN std::uint64_t mass(float p) {
  const double scaled = static_cast<double>(p) * 9223372036854775808.0;
  if (!(scaled > 0.0)) return 0;
  return scaled < 9223372036854775808.0 ? static_cast<std::uint64_t>(scaled) : std::uint64_t{1} << 63;
}

}  // namespace hypgen::math
