// SPDX-License-Identifier: Apache-2.0
// float_hash FUNCTION FIRST COUNT: for COUNT chunks of 2^20 float bit patterns from chunk FIRST on, prints a
// hash of what the function of math.hpp makes of them: the sum over i of (bits + 1) * (2 i + 1) *
// 0x9E3779B97F4A7C15.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "hypgen/math/scalar_functions.hpp"

namespace math = hypgen::math;

namespace {

using Function = float (*)(float);

struct Named {
  const char* name;
  Function function;
};

constexpr Named kFunctions[] = {
    {"sqrt", [](float x) { return math::sqrt(x); }}, {"exp", [](float x) { return math::exp(x); }},
    {"exp2", [](float x) { return math::exp2(x); }}, {"log", [](float x) { return math::log(x); }},
    {"log2", [](float x) { return math::log2(x); }}, {"sin", [](float x) { return math::sin(x); }},
    {"cos", [](float x) { return math::cos(x); }},   {"tan", [](float x) { return math::tan(x); }},
    {"asin", [](float x) { return math::asin(x); }}, {"acos", [](float x) { return math::acos(x); }},
};

std::uint64_t hash(Function function, std::uint32_t chunk) {
  std::uint64_t sum = 0;
  for (std::uint64_t i = 0; i < (std::uint64_t{1} << 20); ++i) {
    const float x = math::from_bits(static_cast<std::uint32_t>((std::uint64_t{chunk} << 20) | i));
    sum += (std::uint64_t{math::canonical_bits(function(x))} + 1) * ((2 * i + 1) * 0x9E3779B97F4A7C15U);
  }
  return sum;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const auto first = static_cast<std::uint32_t>(std::atoi(argv[2]));
  const auto count = static_cast<std::uint32_t>(std::atoi(argv[3]));
  for (const Named& named : kFunctions) {
    if (std::strcmp(named.name, argv[1]) != 0) continue;
    for (std::uint32_t chunk = first; chunk < first + count; ++chunk) {
      std::printf("%016llx\n", static_cast<unsigned long long>(hash(named.function, chunk)));
    }
    return 0;
  }
  return 2;
}
