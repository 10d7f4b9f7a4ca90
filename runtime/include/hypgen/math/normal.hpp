// SPDX-License-Identifier: Apache-2.0
// The normal law and the exponential law in double: the same bits on every host and device.
//
// `hypgen.dsl.float_normal` is the same sequence, operation by operation. The polynomials interpolate at
// Chebyshev nodes; benchmarks/normal_polynomials.py computes them.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "hypgen/core/config.hpp"
#include "hypgen/math/exponentials.hpp"

namespace hypgen::math {

namespace detail {

/// P(X > x) e^(x^2 / 2) of a standard normal X, x >= 0 and finite: (1 + x) times it is a polynomial in
/// (x - 5) / (x + 5), to 2^-52.
template <class T>
HYPGEN_FN T scaled_tail(T x) {
  constexpr double kTerms[23] = {
      -2.8220772290629865e-10, 2.2070652717459774e-09, 3.627373163401201e-09,  -2.54667816805072e-08,
      -2.6286205089898754e-08, 1.8846163807542468e-07, 1.27878221820937e-07,   -1.3004549261799018e-06,
      -7.034644683537101e-08,  9.055745037072721e-06,  -9.896097759279782e-06, -5.360602125091952e-05,
      0.00018233414511643843,  7.79121440702919e-06,   -0.00167607234455447,   0.0065220007252342425,
      -0.015170415402514863,   0.024536963238891124,   -0.026401042966308307,  0.010002352385413518,
      0.031030368425963708,    -0.09155228183401112,   0.46151582985003775};
  const T t = (x - 5.0) / (x + 5.0);
  T sum = kTerms[0] * t + kTerms[1];
  for (int i = 2; i < 23; ++i) sum = sum * t + kTerms[i];
  return sum / (1.0 + x);
}

/// A normal quantile x as x / (p - 1/2): a polynomial in t, which is in [-1, 1] around the middle.
template <class T>
HYPGEN_FN T quantile_series(T t) {
  constexpr double kTerms[22] = {
      -1.171368925093117e-08,  2.432521432742981e-08,  7.948232979900164e-08,   -2.942392415548481e-07,
      1.5743442299138234e-08,  1.5390545633214804e-06, -3.0360753856234887e-06, -1.941437108416409e-06,
      2.0190100343985194e-05,  -3.183769505604272e-05, -4.2513674685119e-05,    0.0002640822038657141,
      -0.00033060938238705837, -0.0007478181314084803, 0.0034859952858551997,   -0.0035968889130826662,
      -0.011702092181392638,   0.05036965361434562,    -0.06393503231828694,    -0.16665818705600238,
      2.12271849188213,        4.677241420053186};
  T sum = kTerms[0] * t + kTerms[1];
  for (int i = 2; i < 22; ++i) sum = sum * t + kTerms[i];
  return sum;
}

/// The x >= 0 with P(X > x) = p, p below 0.0005 and not subnormal: three steps of Newton's method on the
/// logarithm, from the tail's leading terms.
HYPGEN_FN double tail_quantile(double p) {
  const double depth = -log(p);
  const double square = 2.0 * depth - 1.8378770664093456;  // ln(2 pi)
  double x = std::sqrt(square - log(square));
  for (int i = 0; i < 3; ++i) {
    const double scaled = scaled_tail(x);
    const double excess = x * x * 0.5 - log(scaled) - depth;
    x = x - excess * scaled * 2.5066282746310007;  // sqrt(2 pi)
  }
  return x;
}

}  // namespace detail

/// P(X <= x) of a standard normal X, to about 2^-44 of its value; 0 below -37.2, NaN for NaN.
HYPGEN_FN double normal_cdf(double x) {
  if (x != x) return detail::kNaN;
  if (x == 0.0) return 0.5;  // exactly: bins that meet at the mean get the same number of words
  const double size = std::fabs(x);
  const double power = size * size * -0.7213475204444817;  // 1 / (2 ln 2)
  const double tail = power < -1000.0 ? 0.0 : detail::exp2_inside(power) * detail::scaled_tail(size);
  return x > 0.0 ? 1.0 - tail : tail;
}

/// The same of a float, rounded once.
HYPGEN_FN float normal_cdf(float x) { return static_cast<float>(normal_cdf(static_cast<double>(x))); }

namespace detail {

struct KeptCdf {
  double x = 0.0;
  double value = 0.5;  // normal_cdf(0): an entry that nothing was put into is right
};

/// Computes and keeps. Apart from what finds a value, which is short enough to stand in each caller.
HYPGEN_COLD_FN double keep_normal_cdf(KeptCdf& kept, double x) {
  kept = {x, normal_cdf(x)};
  return kept.value;
}

}  // namespace detail

/// The same where few x occur. On the host each thread keeps values that it computed, as to compute one takes many
/// times as long as to find it.
HYPGEN_FN double recurring_normal_cdf(double x) {
#ifdef __CUDA_ARCH__
  return normal_cdf(x);
#else
  constexpr int kBits = 10;
  static thread_local detail::KeptCdf all_kept[1 << kBits];
  std::uint64_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  detail::KeptCdf& kept = all_kept[bits * 0x9E3779B97F4A7C15ULL >> (64 - kBits)];
  return kept.x == x ? kept.value : detail::keep_normal_cdf(kept, x);
#endif
}

/// The x with P(X <= x) = p of a standard normal X, to about 2^-46 of its value. 0 and subnormal p give
/// -infinity, 1 gives infinity, what is no probability NaN.
///
/// Around the middle x / (p - 1/2) is a polynomial in w = -log(4 p (1 - p)) for w <= 6.25.
HYPGEN_FN double normal_quantile(double p) {
  if (!(p >= 0.0 && p <= 1.0)) return detail::kNaN;
  const double rest = 1.0 - p;
  if (p < 2.2250738585072014e-308) return -detail::kInfinity;
  if (rest == 0.0) return detail::kInfinity;
  const double w = -detail::log(4.0 * p * rest);
  if (w > 6.25) return p < 0.5 ? -detail::tail_quantile(p) : detail::tail_quantile(rest);
  return (p - 0.5) * detail::quantile_series(w * 0.32 - 1.0);
}

/// The middle of the w-th of 2^32 equal parts of (0, 1); exact.
HYPGEN_FN double unit_of_word(std::uint32_t w) {
  return (static_cast<double>(w) + 0.5) * 2.3283064365386963e-10;
}

/// A standard normal number: the lower tail's quantile of 31 bits, negated where the top bit is set.
HYPGEN_FN double normal_of_word(std::uint32_t w) {
  const double x = normal_quantile(unit_of_word(w & 0x7FFFFFFFU));
  return (w >> 31) != 0 ? -x : x;
}

/// An exponential number of mean 1.
HYPGEN_FN double exponential_of_word(std::uint32_t w) { return -detail::log(unit_of_word(w)); }

}  // namespace hypgen::math
