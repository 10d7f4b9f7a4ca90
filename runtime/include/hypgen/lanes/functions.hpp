// SPDX-License-Identifier: Apache-2.0
// The functions of generated models in lanes: the same steps as in hypgen/math, so the same bits.
//
// Functions of floats work on doubles, half of the lanes at a time. What few lanes need, or few models, is
// computed lane by lane.
#pragma once

#include <cstdint>

#include "hypgen/lanes/vectors.hpp"
#include "hypgen/math/scalar_functions.hpp"

namespace hypgen::lanes {

HYPGEN_FN Doubles pick(Longs mask, Doubles a, Doubles b) { return mask ? a : b; }
HYPGEN_FN Masses bits_of(Doubles x) { return reinterpret_cast<Masses>(x); }
HYPGEN_FN Doubles from_bits(Masses bits) { return reinterpret_cast<Doubles>(bits); }
HYPGEN_FN Doubles fabs(Doubles x) { return from_bits(bits_of(x) & 0x7FFFFFFFFFFFFFFFU); }

HYPGEN_FN Doubles floor(Doubles x) {
#if defined(HYPGEN_LANES_AVX512)
  return _mm512_roundscale_pd(x, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
#elif defined(__AVX2__)
  return _mm256_floor_pd(x);
#else
  for (int i = 0; i < kLanes / 2; ++i) x[i] = std::floor(x[i]);
  return x;
#endif
}

HYPGEN_FN Doubles rint(Doubles x) {
#if defined(HYPGEN_LANES_AVX512)
  return _mm512_roundscale_pd(x, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
#elif defined(__AVX2__)
  return _mm256_round_pd(x, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
#else
  for (int i = 0; i < kLanes / 2; ++i) x[i] = std::rint(x[i]);
  return x;
#endif
}

HYPGEN_FN Doubles sqrt(Doubles x) {
#if defined(HYPGEN_LANES_AVX512)
  return _mm512_sqrt_pd(x);
#elif defined(__AVX2__)
  return _mm256_sqrt_pd(x);
#else
  for (int i = 0; i < kLanes / 2; ++i) x[i] = std::sqrt(x[i]);
  return x;
#endif
}

/// Entries of a table of 16.
HYPGEN_FN Doubles entries_of_16(const double* table, Masses position) {
  position &= 15;
#if defined(HYPGEN_LANES_AVX512)
  return _mm512_i64gather_pd(reinterpret_cast<__m512i>(position), table, 8);
#elif defined(__AVX2__)
  return _mm256_i64gather_pd(table, reinterpret_cast<__m256i>(position), 8);
#else
  Doubles found;
  for (int i = 0; i < kLanes / 2; ++i) found[i] = table[position[i]];
  return found;
#endif
}

/// A whole number below 2^51 as the low bits of a word.
HYPGEN_FN Masses whole_bits(Doubles whole) { return bits_of(whole + 6755399441055744.0); }

/// A whole number in 0 .. 2^63, or a double that has no fraction there, as a mass.
HYPGEN_FN Masses to_masses(Doubles whole) {
  const Doubles upper = floor(whole * 2.3283064365386963e-10);
  const Doubles lower = whole - upper * 4294967296.0;
  return ((bits_of(upper + 4503599627370496.0) & 0xFFFFFFFFU) << 32) + (bits_of(lower + 4503599627370496.0) & 0xFFFFFFFFU);
}

/// `f` of both halves.
template <class F>
HYPGEN_FN Float by_halves(F f, Float x) {
  return Float(joined<float>(__builtin_convertvector(f(x.wide(0)), FloatHalf),
                             __builtin_convertvector(f(x.wide(1)), FloatHalf)));
}
template <class F>
HYPGEN_FN Float by_halves(F f, Float x, Float y) {
  return Float(joined<float>(__builtin_convertvector(f(x.wide(0), y.wide(0)), FloatHalf),
                             __builtin_convertvector(f(x.wide(1), y.wide(1)), FloatHalf)));
}

/// A function of scalars, lane by lane.
template <class Result, class F, class... Values>
__attribute__((noinline)) Lanes<Result> each_lane(F f, const Values&... values) {
  Lanes<Result> results;
  for (int i = 0; i < kLanes; ++i) results.set(i, f(values[i]...));
  return results;
}

// math/exponentials.hpp, math/trigonometry.hpp and math/normal.hpp, half of the lanes ---------------------------

HYPGEN_FN Doubles log(Doubles x) {
  const Masses bits = bits_of(x);
  // The exponent's bits, a whole number below 2048, as a double.
  Doubles exponent = from_bits((bits >> 52) | 0x4330000000000000U) - 4503599627370496.0 - 1023.0;
  Doubles mantissa = from_bits((bits & 0x000FFFFFFFFFFFFFU) | 0x3FF0000000000000U);
  const Longs large = mantissa > 1.4142135623730951;
  mantissa = pick(large, mantissa * 0.5, mantissa);
  exponent = pick(large, exponent + 1.0, exponent);
  const Doubles z = (mantissa - 1.0) / (mantissa + 1.0);
  const Doubles value = exponent * 0.6931471805599453 + (z * math::detail::atanh_over(z)) * 2.0;
  const Doubles nan = math::detail::kNaN - Doubles{}, infinity = math::detail::kInfinity - Doubles{};
  return pick(x > 0.0, pick(x < math::detail::kInfinity, value, infinity), pick(x == 0.0, -infinity, nan));
}

/// 2^y for |y| <= 1000.
HYPGEN_FN Doubles exp2_inside(Doubles y) {
  const Doubles n = floor(y + 0.5);
  const Doubles t = (y - n) * 0.6931471805599453;
  return math::detail::exp_series(t) * from_bits((whole_bits(n) + 1023) << 52);
}

HYPGEN_FN Doubles exp2(Doubles y) {
  const Doubles inside = exp2_inside(pick(fabs(y) <= 200.0, y, Doubles{}));
  const Doubles nan = math::detail::kNaN - Doubles{}, infinity = math::detail::kInfinity - Doubles{};
  return pick(y > 200.0, infinity, pick(y < -200.0, Doubles{}, pick(y == y, inside, nan)));
}

struct HalfAngle {
  Doubles rest;
  Masses quadrant;
};
HYPGEN_FN HalfAngle reduce(Doubles x) {
  const Doubles n = floor(x * 0.6366197723675814 + 0.5);
  const Doubles rest =
      ((x - n * 1.5707963267341256) - n * 6.077100506303966e-11) - n * 2.0222662487959506e-21;
  return {rest, whole_bits(n)};
}

/// sin for |x| <= 2^20; `turns` quarters of a circle ahead.
HYPGEN_FN Doubles sin(Doubles x) {
  const HalfAngle angle = reduce(fabs(x));
  const Longs odd = (angle.quadrant & 1) != 0;
  const Doubles value = pick(odd, math::detail::cos_near(angle.rest), math::detail::sin_near(angle.rest));
  return from_bits(bits_of(value) ^ ((angle.quadrant & 2) << 62) ^ (bits_of(x) & 0x8000000000000000U));
}
HYPGEN_FN Doubles cos(Doubles x) {
  const HalfAngle angle = reduce(fabs(x));
  const Longs odd = (angle.quadrant & 1) != 0;
  const Doubles value = pick(odd, math::detail::sin_near(angle.rest), math::detail::cos_near(angle.rest));
  return from_bits(bits_of(value) ^ (((angle.quadrant + 1) & 2) << 62));
}

HYPGEN_FN Doubles atan2(Doubles y, Doubles x) {
  const Doubles height = fabs(y), breadth = fabs(x);
  const Longs steep = height > breadth;
  Doubles a = pick(steep, breadth, height), b = pick(steep, height, breadth);
  b = pick(b == 0.0, Doubles{} + 1.0, b);
  const Longs endless = b == math::detail::kInfinity;
  a = pick(endless, pick(a == math::detail::kInfinity, Doubles{} + 1.0, Doubles{}), a);
  b = pick(endless, Doubles{} + 1.0, b);
  const Doubles k = floor(a / b * 8.0 + 0.5);
  const Doubles c = k * 0.125;
  const Doubles u = (a - c * b) / (b + c * a);
  Doubles angle = entries_of_16(math::detail::eighths(), whole_bits(k)) + math::detail::atan_series(u);
  angle = pick(steep, 1.5707963267948966 - angle, angle);
  angle = pick((bits_of(x) >> 63) != 0, 3.141592653589793 - angle, angle);
  angle = from_bits(bits_of(angle) ^ (bits_of(y) & 0x8000000000000000U));
  return pick((x == x) & (y == y), angle, math::detail::kNaN - Doubles{});
}

HYPGEN_FN Doubles normal_cdf(Doubles x) {
  const Doubles size = fabs(x);
  const Doubles power = size * size * -0.7213475204444817;
  const Longs far = power < -1000.0;
  const Doubles inside = exp2_inside(pick(far, Doubles{}, power)) * math::detail::scaled_tail(size);
  const Doubles tail = pick(far, Doubles{}, inside);
  const Doubles value = pick(x > 0.0, 1.0 - tail, tail);
  return pick(x == 0.0, Doubles{} + 0.5, pick(x == x, value, math::detail::kNaN - Doubles{}));
}

/// A standard normal number of each word.
HYPGEN_FN Double normal_of_word(Word word) {
  const Word lower = word & 0x7FFFFFFFU;
  Double result;
  Mask tail(false);
  Double w;
  for (int part = 0; part < 2; ++part) {
    const Doubles p = (lower.wide(part) + 0.5) * 2.3283064365386963e-10;
    const Doubles distance = -log(4.0 * p * (1.0 - p));
    const Doubles x = (p - 0.5) * math::detail::quantile_series(distance * 0.32 - 1.0);
    (part == 0 ? w.low : w.high) = distance;
    (part == 0 ? result.low : result.high) = x;
  }
  const Mask negated = (word & 0x80000000U) != 0U;
  result = select_lanes<double>(negated, -result, result);
  tail = w > Double(6.25);
  if (HYPGEN_RARELY(any(tail))) {
    for (int i = 0; i < kLanes; ++i) {
      if (tail.v[i] != 0) result.set(i, math::normal_of_word(word[i]));
    }
  }
  return result;
}

}  // namespace hypgen::lanes

namespace hypgen::math {

using lanes::Double;
using lanes::Float;
using lanes::Int;
using lanes::Mask;

template <class T>
HYPGEN_FN lanes::Lanes<T> min(lanes::Lanes<T> a, lanes::Lanes<T> b) {
  return select(b < a, b, a);
}
HYPGEN_FN Float min(Float a, Float b) { return min<float>(a, b); }
HYPGEN_FN Int min(Int a, Int b) { return min<std::int32_t>(a, b); }
template <class T>
HYPGEN_FN lanes::Lanes<T> max(lanes::Lanes<T> a, lanes::Lanes<T> b) {
  return select(a < b, b, a);
}
HYPGEN_FN Float max(Float a, Float b) { return max<float>(a, b); }
HYPGEN_FN Int max(Int a, Int b) { return max<std::int32_t>(a, b); }
HYPGEN_FN Float clamp(Float x, Float low, Float high) {
  return select(x < low, low, select(high < x, high, x));
}
HYPGEN_FN Int clamp(Int x, Int low, Int high) { return select(x < low, low, select(high < x, high, x)); }
HYPGEN_FN Int sign(Int x) { return select(x > Int(0), Int(1), select(x < Int(0), Int(-1), Int(0))); }
HYPGEN_FN Float sign(Float x) {
  return select(x > Float(0.0F), Float(1.0F), select(x < Float(0.0F), Float(-1.0F), Float(0.0F)));
}
HYPGEN_FN Int abs(Int x) { return select(x < Int(0), -x, x); }
HYPGEN_FN Float abs(Float x) { return lanes::from_bits(lanes::to_bits(x) & 0x7FFFFFFFU); }
HYPGEN_FN Mask is_nan(Float x) { return x != x; }
HYPGEN_FN Float from_zero(Float x) { return select(x == Float(0.0F), Float(0.0F), Float(0.0F) - x); }

HYPGEN_FN Int floordiv(Int a, Int b) {
  return lanes::each_lane<std::int32_t>([](std::int32_t x, std::int32_t y) { return floordiv(x, y); }, a, b);
}
HYPGEN_FN Int mod(Int a, Int b) {
  return lanes::each_lane<std::int32_t>([](std::int32_t x, std::int32_t y) { return mod(x, y); }, a, b);
}

namespace detail {

HYPGEN_FN lanes::IntHalf saturate(lanes::Doubles whole, double low, double high) {
  const lanes::Doubles least = low - lanes::Doubles{}, most = high - lanes::Doubles{};
  return __builtin_convertvector(lanes::pick(whole > low, lanes::pick(whole < high, whole, most), least),
                                 lanes::IntHalf);
}

template <class F>
HYPGEN_FN Int to_int(F round, Float x, std::int32_t low, std::int32_t high) {
  return Int(lanes::joined<std::int32_t>(saturate(round(x.wide(0)), low, high), saturate(round(x.wide(1)), low, high)));
}

}  // namespace detail

HYPGEN_FN Int floor_to_int(Float x, std::int32_t low, std::int32_t high) {
  return detail::to_int([](lanes::Doubles y) { return lanes::floor(y); }, x, low, high);
}
HYPGEN_FN Int ceil_to_int(Float x, std::int32_t low, std::int32_t high) {
  return detail::to_int([](lanes::Doubles y) { return -lanes::floor(-y); }, x, low, high);
}
HYPGEN_FN Int round_to_int(Float x, std::int32_t low, std::int32_t high) {
  return detail::to_int([](lanes::Doubles y) { return lanes::rint(y); }, x, low, high);
}

/// A reward in fixed point, as a double that is a whole number: a step's sum is far below 2^53.
template <int kBits = kFixedBits>
HYPGEN_FN Double to_fixed(Float x) {
  constexpr double kScale = power_of_two(kBits);
  constexpr double kLimit = static_cast<double>(kFixedLimit);
  Double result;
  for (int part = 0; part < 2; ++part) {
    const lanes::Doubles scaled = lanes::rint(x.wide(part) * kScale);
    const lanes::Doubles limit = kLimit - lanes::Doubles{};
    const lanes::Doubles inside =
        lanes::pick(scaled < -kLimit, -limit, lanes::pick(scaled > kLimit, limit, scaled));
    (part == 0 ? result.low : result.high) = lanes::pick(scaled == scaled, inside, lanes::Doubles{});
  }
  return result;
}
template <int kBits = kFixedBits>
HYPGEN_FN Double to_fixed(Int x) {
  constexpr double kScale = power_of_two(kBits);
  constexpr double kLimit = static_cast<double>(kFixedLimit);
  Double result;
  for (int part = 0; part < 2; ++part) {
    const lanes::Doubles scaled = lanes::rint(x.wide(part) * kScale);
    const lanes::Doubles limit = kLimit - lanes::Doubles{};
    (part == 0 ? result.low : result.high) =
        lanes::pick(scaled < -kLimit, -limit, lanes::pick(scaled > kLimit, limit, scaled));
  }
  return result;
}
/// M(p) of a probability, as `mass` of a scalar.
HYPGEN_FN lanes::Masses mass(lanes::Doubles p) {
  const lanes::Doubles scaled = p * 9223372036854775808.0, most = 9223372036854775808.0 - lanes::Doubles{};
  const lanes::Doubles whole = lanes::pick(scaled < most, lanes::floor(scaled), most);
  return lanes::to_masses(lanes::pick(scaled > 0.0, whole, lanes::Doubles{}));
}
HYPGEN_FN lanes::Lanes<std::uint64_t> mass(Float p) { return {mass(p.wide(0)), mass(p.wide(1))}; }

HYPGEN_FN Double saturate_fixed(Double x) {
  constexpr double kLimit = static_cast<double>(kFixedLimit);
  return select(x < Double(-kLimit), Double(-kLimit), select(x > Double(kLimit), Double(kLimit), x));
}
HYPGEN_FN Mask is_saturated(Double x) {
  constexpr double kLimit = static_cast<double>(kFixedLimit);
  return either(x >= Double(kLimit), x <= Double(-kLimit));
}
template <int kBits = kFixedBits>
HYPGEN_FN Float from_fixed(Double x) {
  constexpr double kUnit = power_of_two(-kBits);
  return lanes::as<float>(x * Double(kUnit));
}

HYPGEN_FN Float sqrt(Float x) {
  return lanes::by_halves([](lanes::Doubles y) { return lanes::sqrt(y); }, x);
}
HYPGEN_FN Float log(Float x) {
  return lanes::by_halves([](lanes::Doubles y) { return lanes::log(y); }, x);
}
HYPGEN_FN Float exp2(Float x) {
  return lanes::by_halves([](lanes::Doubles y) { return lanes::exp2(y); }, x);
}
HYPGEN_FN Float exp(Float x) {
  return lanes::by_halves([](lanes::Doubles y) { return lanes::exp2(y * 1.4426950408889634); }, x);
}
HYPGEN_FN Float hypot(Float a, Float b) {
  return lanes::by_halves([](lanes::Doubles x, lanes::Doubles y) { return lanes::sqrt(x * x + y * y); }, a, b);
}

/// Whether a lane's angle is too large for the short reduction, or no number.
HYPGEN_FN bool any_large(Float x) { return lanes::any(!(abs(x) <= Float(1048576.0F))); }

HYPGEN_FN Float sin(Float x) {
  if (HYPGEN_RARELY(any_large(x))) return lanes::each_lane<float>([](float y) { return sin(y); }, x);
  return lanes::by_halves([](lanes::Doubles y) { return lanes::sin(y); }, x);
}
HYPGEN_FN Float cos(Float x) {
  if (HYPGEN_RARELY(any_large(x))) return lanes::each_lane<float>([](float y) { return cos(y); }, x);
  return lanes::by_halves([](lanes::Doubles y) { return lanes::cos(y); }, x);
}
HYPGEN_FN Float atan2(Float y, Float x) {
  return lanes::by_halves([](lanes::Doubles a, lanes::Doubles b) { return lanes::atan2(a, b); }, y, x);
}
HYPGEN_FN Float tan(Float x) {
  return lanes::each_lane<float>([](float y) { return tan(y); }, x);
}
HYPGEN_FN Float asin(Float x) {
  return lanes::each_lane<float>([](float y) { return asin(y); }, x);
}
HYPGEN_FN Float acos(Float x) {
  return lanes::each_lane<float>([](float y) { return acos(y); }, x);
}
HYPGEN_FN Float log2(Float x) {
  return lanes::each_lane<float>([](float y) { return log2(y); }, x);
}
HYPGEN_FN Float pow(Float a, Float b) {
  return lanes::each_lane<float>([](float x, float y) { return pow(x, y); }, a, b);
}
HYPGEN_FN Float normal_cdf(Float x) {
  return lanes::by_halves([](lanes::Doubles y) { return lanes::normal_cdf(y); }, x);
}

}  // namespace hypgen::math
