// SPDX-License-Identifier: Apache-2.0
// Reads pairs of float bits and writes, for each pair, what every function of math.hpp makes of it.
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <vector>

#include "hypgen/math/scalar_functions.hpp"

namespace math = hypgen::math;

namespace {

struct Pair {
  std::uint32_t a;
  std::uint32_t b;
};

float from_float_bits(std::uint32_t bits) {
  float x = 0.0F;
  std::memcpy(&x, &bits, sizeof x);
  return x;
}

std::int64_t canonical_bits(double x) {
  std::int64_t bits = 0;
  if (x == x) std::memcpy(&bits, &x, sizeof bits);
  return bits;
}

void append(std::vector<std::int64_t>& out, Pair pair) {
  const float a = from_float_bits(pair.a);
  const float b = from_float_bits(pair.b);
  for (const float x : {math::exp(a),
                        math::exp2(a),
                        math::log(a),
                        math::log2(a),
                        math::sqrt(a),
                        math::pow(a, b),
                        math::hypot(a, b),
                        math::abs(a),
                        math::sign(a),
                        math::min(a, b),
                        math::max(a, b),
                        math::clamp(a, -1.5F, 2.0F),
                        math::sin(a),
                        math::cos(a),
                        math::tan(a),
                        math::asin(a),
                        math::acos(a),
                        math::atan2(a, b),
                        math::from_fixed(static_cast<std::int64_t>(pair.a) * 65537 - pair.b),
                        math::from_fixed<-9>(static_cast<std::int64_t>(pair.a) * 65537 - pair.b)}) {
    out.push_back(math::canonical_bits(x));
  }
  const auto i = static_cast<std::int32_t>(pair.a);
  const auto j = static_cast<std::int32_t>(pair.b);
  const std::int32_t divisor = j % 17;
  for (const std::int32_t x :
       {math::floordiv(i, j), math::mod(i, j), math::floordiv(i, divisor), math::mod(i, divisor),
        math::floor_to_int(a, -100, 1000), math::ceil_to_int(a, -100, 1000),
        math::round_to_int(a, INT32_MIN, INT32_MAX), math::sign(i)}) {
    out.push_back(x);
  }
  out.push_back(math::to_fixed(a));
  out.push_back(math::to_fixed(i));
  out.push_back(math::to_fixed<-9>(a));
  out.push_back(math::to_fixed<-9>(i));
  out.push_back(math::to_fixed<50>(a));
  out.push_back(math::to_fixed<50>(i));
  out.push_back(static_cast<std::int64_t>(math::mass(a)));
  for (const double x :
       {math::normal_cdf(static_cast<double>(a)), math::normal_quantile(static_cast<double>(a)),
        math::normal_of_word(pair.a), math::exponential_of_word(pair.a)}) {
    out.push_back(canonical_bits(x));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  std::FILE* in = std::fopen(argv[1], "rb");
  std::FILE* out = std::fopen(argv[2], "wb");
  if (in == nullptr || out == nullptr) return 1;
  std::vector<Pair> pairs(4096);
  std::vector<std::int64_t> row;
  while (const std::size_t count = std::fread(pairs.data(), sizeof(Pair), pairs.size(), in)) {
    row.clear();
    for (std::size_t i = 0; i < count; ++i) append(row, pairs[i]);
    if (std::fwrite(row.data(), sizeof(row[0]), row.size(), out) != row.size()) return 1;
  }
  std::fclose(in);
  return std::fclose(out);
}
