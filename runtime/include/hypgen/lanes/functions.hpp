// SPDX-License-Identifier: Apache-2.0
// The functions of generated models in lanes: the same steps as in hypgen/math, so the same bits.
//
// Functions of floats work on doubles, two registers of them side by side: their long chains of operations wait for
// each other, so that two chains take hardly longer than one. What few lanes or few models need is computed lane by
// lane.
#pragma once

#include <cstdint>

#include "hypgen/lanes/vectors.hpp"
#include "hypgen/math/scalar_functions.hpp"

namespace hypgen::lanes {

/// A truth of each lane, as wide as a double.
struct Wides {
  Longs low;
  Longs high;
};

#define HYPGEN_LANES_TEST(name, sign)              \
  template <class T>                               \
  HYPGEN_FN Wides name(Lanes<T> a, Lanes<T> b) {   \
    return {a.low sign b.low, a.high sign b.high}; \
  }                                                \
  HYPGEN_FN Wides name(Double a, double b) { return name(a, Double(b)); }
HYPGEN_LANES_TEST(below, <)
HYPGEN_LANES_TEST(above, >)
HYPGEN_LANES_TEST(within, <=)
HYPGEN_LANES_TEST(from, >=)
HYPGEN_LANES_TEST(equal, ==)
#undef HYPGEN_LANES_TEST

HYPGEN_FN Wides both(Wides a, Wides b) { return {a.low & b.low, a.high & b.high}; }
HYPGEN_FN bool any(Wides a) { return any(narrow(a.low, a.high)); }
HYPGEN_FN Double pick(Wides mask, Double a, Double b) {
  return {mask.low ? a.low : b.low, mask.high ? a.high : b.high};
}

using Bits = Lanes<std::uint64_t>;

HYPGEN_FN Bits bits_of(Double x) {
  return {reinterpret_cast<Masses>(x.low), reinterpret_cast<Masses>(x.high)};
}
HYPGEN_FN Double from_bits(Bits bits) {
  return {reinterpret_cast<Doubles>(bits.low), reinterpret_cast<Doubles>(bits.high)};
}
/// Whether one of these bits is set.
HYPGEN_FN Wides has(Bits bits, std::uint64_t which) {
  return {(bits.low & which) != 0, (bits.high & which) != 0};
}
HYPGEN_FN Double fabs(Double x) { return from_bits(bits_of(x) & Bits(0x7FFFFFFFFFFFFFFFU)); }

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

HYPGEN_FN Double floor(Double x) { return {floor(x.low), floor(x.high)}; }
HYPGEN_FN Double rint(Double x) { return {rint(x.low), rint(x.high)}; }
HYPGEN_FN Double sqrt(Double x) { return {sqrt(x.low), sqrt(x.high)}; }

/// A whole number below 2^51 as the low bits of a word.
HYPGEN_FN Bits whole_bits(Double whole) { return bits_of(whole + 6755399441055744.0); }

/// A whole number in 0 .. 2^63 as a mass.
HYPGEN_FN Bits to_masses(Double whole) {
  const Double upper = floor(whole * 2.3283064365386963e-10);
  const Double lower = whole - upper * 4294967296.0;
  const Bits low32(0xFFFFFFFFU);
  return ((bits_of(upper + 4503599627370496.0) & low32) << Bits(32)) +
         (bits_of(lower + 4503599627370496.0) & low32);
}

/// A function of scalars, lane by lane.
template <class Result, class F, class... Values>
__attribute__((noinline)) Lanes<Result> each_lane(F f, const Values&... values) {
  Lanes<Result> results;
  for (int i = 0; i < kLanes; ++i) results.set(i, f(values[i]...));
  return results;
}

// math/exponentials.hpp, math/trigonometry.hpp and math/normal.hpp ------------------------------------------

HYPGEN_FN Double log(Double x) {
  const Double infinity(math::detail::kInfinity);
  const Bits bits = bits_of(x);
  // The exponent's bits, a whole number below 2048, as a double.
  const Double biased = from_bits((bits >> Bits(52)) | Bits(0x4330000000000000U)) - 4503599627370496.0;
  Double exponent = biased - 1023.0;
  Double mantissa = from_bits((bits & Bits(0x000FFFFFFFFFFFFFU)) | Bits(0x3FF0000000000000U));
  const Wides large = above(mantissa, 1.4142135623730951);
  mantissa = pick(large, mantissa * 0.5, mantissa);
  exponent = pick(large, exponent + 1.0, exponent);
  const Double z = (mantissa - 1.0) / (mantissa + 1.0);
  const Double value = exponent * 0.6931471805599453 + (z * math::detail::atanh_over(z)) * 2.0;
  return pick(above(x, 0.0), pick(below(x, infinity), value, infinity),
              pick(equal(x, 0.0), -infinity, Double(math::detail::kNaN)));
}

/// 2^y for |y| <= 1000.
HYPGEN_FN Double exp2_inside(Double y) {
  const Double n = floor(y + 0.5);
  const Double t = (y - n) * 0.6931471805599453;
  return math::detail::exp_series(t) * from_bits((whole_bits(n) + Bits(1023)) << Bits(52));
}

HYPGEN_FN Double exp2(Double y) {
  const Double inside = exp2_inside(pick(within(fabs(y), 200.0), y, Double(0.0)));
  const Double small = pick(below(y, -200.0), Double(0.0), inside);
  return pick(above(y, 200.0), Double(math::detail::kInfinity),
              pick(equal(y, y), small, Double(math::detail::kNaN)));
}

struct LanesAngle {
  Double rest;
  Bits quadrant;
};
/// Of 0 <= x <= 2^20.
HYPGEN_FN LanesAngle reduce(Double x) {
  const Double n = floor(x * 0.6366197723675814 + 0.5);
  const Double rest = ((x - n * 1.5707963267341256) - n * 6.077100506303966e-11) - n * 2.0222662487959506e-21;
  return {rest, whole_bits(n)};
}

/// sin and cos for |x| <= 2^20.
HYPGEN_FN Double sin(Double x) {
  const LanesAngle angle = reduce(fabs(x));
  const Wides odd = has(angle.quadrant, 1);
  const Double value = pick(odd, math::detail::cos_near(angle.rest), math::detail::sin_near(angle.rest));
  const Bits sign = ((angle.quadrant & Bits(2)) << Bits(62)) ^ (bits_of(x) & Bits(0x8000000000000000U));
  return from_bits(bits_of(value) ^ sign);
}
HYPGEN_FN Double cos(Double x) {
  const LanesAngle angle = reduce(fabs(x));
  const Wides odd = has(angle.quadrant, 1);
  const Double value = pick(odd, math::detail::sin_near(angle.rest), math::detail::cos_near(angle.rest));
  return from_bits(bits_of(value) ^ (((angle.quadrant + Bits(1)) & Bits(2)) << Bits(62)));
}

HYPGEN_FN Double atan2(Double y, Double x) {
  const Double height = fabs(y), breadth = fabs(x), one(1.0), infinity(math::detail::kInfinity);
  const Wides steep = above(height, breadth);
  Double a = pick(steep, breadth, height), b = pick(steep, height, breadth);
  b = pick(equal(b, 0.0), one, b);
  const Wides endless = equal(b, infinity);
  a = pick(endless, pick(equal(a, infinity), one, Double(0.0)), a);
  b = pick(endless, one, b);
  const Double k = floor(a / b * 8.0 + 0.5);
  const Double c = k * 0.125;
  const Double u = (a - c * b) / (b + c * a);
  const Bits place = whole_bits(k);
  const double* const table = math::detail::eighths();
  const Double nearest(entries_of_16(table, place.low), entries_of_16(table, place.high));
  Double angle = nearest + math::detail::atan_series(u);
  angle = pick(steep, 1.5707963267948966 - angle, angle);
  angle = pick(has(bits_of(x), 0x8000000000000000U), 3.141592653589793 - angle, angle);
  angle = from_bits(bits_of(angle) ^ (bits_of(y) & Bits(0x8000000000000000U)));
  return pick(both(equal(x, x), equal(y, y)), angle, Double(math::detail::kNaN));
}

HYPGEN_FN Double normal_cdf(Double x) {
  const Double size = fabs(x);
  const Double power = size * size * -0.7213475204444817;
  const Wides far = below(power, -1000.0);
  const Double inside = exp2_inside(pick(far, Double(0.0), power)) * math::detail::scaled_tail(size);
  const Double tail = pick(far, Double(0.0), inside);
  const Double value = pick(above(x, 0.0), 1.0 - tail, tail);
  return pick(equal(x, 0.0), Double(0.5), pick(equal(x, x), value, Double(math::detail::kNaN)));
}

/// A standard normal number of each word.
HYPGEN_FN Double normal_of_word(Word word) {
  const Double p = (as<double>(word & 0x7FFFFFFFU) + 0.5) * 2.3283064365386963e-10;
  const Double distance = -log(4.0 * p * (1.0 - p));
  Double result = (p - 0.5) * math::detail::quantile_series(distance * 0.32 - 1.0);
  result = select_lanes<double>((word & 0x80000000U) != 0U, -result, result);
  const Mask tail = distance > Double(6.25);
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

HYPGEN_FN Int saturate(Double whole, double low, double high) {
  const Double upper = lanes::pick(lanes::below(whole, high), whole, Double(high));
  return lanes::as<std::int32_t>(lanes::pick(lanes::above(whole, low), upper, Double(low)));
}

/// A number in fixed point, saturated; 0 for NaN.
HYPGEN_FN Double saturate_whole(Double scaled) {
  constexpr double kLimit = static_cast<double>(kFixedLimit);
  const Double upper = lanes::pick(lanes::above(scaled, kLimit), Double(kLimit), scaled);
  const Double inside = lanes::pick(lanes::below(scaled, -kLimit), Double(-kLimit), upper);
  return lanes::pick(lanes::equal(scaled, scaled), inside, Double(0.0));
}

}  // namespace detail

HYPGEN_FN Int floor_to_int(Float x, std::int32_t low, std::int32_t high) {
  return detail::saturate(lanes::floor(lanes::as<double>(x)), low, high);
}
HYPGEN_FN Int ceil_to_int(Float x, std::int32_t low, std::int32_t high) {
  return detail::saturate(-lanes::floor(-lanes::as<double>(x)), low, high);
}
HYPGEN_FN Int round_to_int(Float x, std::int32_t low, std::int32_t high) {
  return detail::saturate(lanes::rint(lanes::as<double>(x)), low, high);
}

/// A reward in fixed point, as a double that is a whole number: a step's sum is far below 2^53.
template <int kBits = kFixedBits>
HYPGEN_FN Double to_fixed(Float x) {
  constexpr double kScale = power_of_two(kBits);
  return detail::saturate_whole(lanes::rint(lanes::as<double>(x) * kScale));
}
template <int kBits = kFixedBits>
HYPGEN_FN Double to_fixed(Int x) {
  constexpr double kScale = power_of_two(kBits);
  return detail::saturate_whole(lanes::rint(lanes::as<double>(x) * kScale));
}
/// M(p) of a probability, as `mass` of a scalar.
HYPGEN_FN lanes::Bits mass(Float p) {
  const Double scaled = lanes::as<double>(p) * 9223372036854775808.0, most(9223372036854775808.0);
  const Double whole = lanes::pick(lanes::below(scaled, most), lanes::floor(scaled), most);
  return lanes::to_masses(lanes::pick(lanes::above(scaled, 0.0), whole, Double(0.0)));
}

/// T(p) of a probability, as `threshold` of a scalar.
HYPGEN_FN lanes::Bits threshold(Float p) {
  const Double scaled = lanes::as<double>(p) * 4294967296.0, most(4294967296.0);
  const Double whole = lanes::pick(lanes::below(scaled, most), lanes::floor(scaled), most);
  return lanes::to_masses(lanes::pick(lanes::above(scaled, 0.0), whole, Double(0.0)));
}

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

HYPGEN_FN Float sqrt(Float x) { return lanes::as<float>(lanes::sqrt(lanes::as<double>(x))); }
HYPGEN_FN Float log(Float x) { return lanes::as<float>(lanes::log(lanes::as<double>(x))); }
HYPGEN_FN Float exp2(Float x) { return lanes::as<float>(lanes::exp2(lanes::as<double>(x))); }
HYPGEN_FN Float exp(Float x) {
  return lanes::as<float>(lanes::exp2(lanes::as<double>(x) * 1.4426950408889634));
}
HYPGEN_FN Float hypot(Float a, Float b) {
  const Double x = lanes::as<double>(a), y = lanes::as<double>(b);
  return lanes::as<float>(lanes::sqrt(x * x + y * y));
}

/// Whether a lane's angle is too large for the short reduction, or no number.
HYPGEN_FN bool any_large(Float x) { return lanes::any(!(abs(x) <= Float(1048576.0F))); }

HYPGEN_FN Float sin(Float x) {
  if (HYPGEN_RARELY(any_large(x))) return lanes::each_lane<float>([](float y) { return sin(y); }, x);
  return lanes::as<float>(lanes::sin(lanes::as<double>(x)));
}
HYPGEN_FN Float cos(Float x) {
  if (HYPGEN_RARELY(any_large(x))) return lanes::each_lane<float>([](float y) { return cos(y); }, x);
  return lanes::as<float>(lanes::cos(lanes::as<double>(x)));
}
HYPGEN_FN Float atan2(Float y, Float x) {
  return lanes::as<float>(lanes::atan2(lanes::as<double>(y), lanes::as<double>(x)));
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
HYPGEN_FN Float normal_cdf(Float x) { return lanes::as<float>(lanes::normal_cdf(lanes::as<double>(x))); }

}  // namespace hypgen::math
