// SPDX-License-Identifier: Apache-2.0
// Functions in lanes against the same functions of scalars, bit for bit: prints what differs.
#include <cstdio>
#include <cstring>

#include "hypgen/lanes/draws.hpp"

namespace {

using hypgen::lanes::Float;
using hypgen::lanes::Int;
using hypgen::lanes::kLanes;
using hypgen::lanes::Word;
namespace math = hypgen::math;
namespace dist = hypgen::dist;

constexpr int kBatches = 4000;
int differing = 0;

// A number of each lane: whole numbers, moderate floats, and any bits.
std::uint32_t word_of(std::uint32_t i, std::uint32_t column) {
  return hypgen::philox(1, 2, {{i, column, 0, 0}}).words[0];
}
float float_of(std::uint32_t i, std::uint32_t column) {
  const std::uint32_t word = word_of(i, column);
  if (i % 4 == 0) return math::from_bits(word);
  if (i % 4 == 1) return static_cast<float>(static_cast<std::int32_t>(word % 41) - 20) * 0.5F;
  return static_cast<float>(word) * (i % 4 == 2 ? 2.3e-10F : 4e-8F) - (i % 8 == 3 ? 50.0F : 0.0F);
}

template <class Found, class Wanted>
void same(const char* what, std::uint32_t i, Found found, Wanted wanted) {
  static_assert(sizeof found == sizeof wanted);
  const bool both_nan = found != found && wanted != wanted;
  if (both_nan || std::memcmp(&found, &wanted, sizeof found) == 0) return;
  if (++differing < 20) std::printf("%s of number %u\n", what, i);
}

struct Batch {
  std::uint32_t first;
  Float x, y;
  Word w, small;
  Int n;

  explicit Batch(std::uint32_t number) : first(number * kLanes) {
    for (int i = 0; i < kLanes; ++i) {
      const std::uint32_t at = first + static_cast<std::uint32_t>(i);
      x.set(i, float_of(at, 0));
      y.set(i, float_of(at, 1));
      w.set(i, word_of(at, 2));
      small.set(i, word_of(at, 2) >> (at % 32));
      n.set(i, static_cast<std::int32_t>(word_of(at, 3)) >> (at % 31));
    }
  }
};

#define SAME(what, in_lanes, alone)                                             \
  {                                                                             \
    const auto found = in_lanes;                                                \
    for (int i = 0; i < kLanes; ++i) {                                          \
      [[maybe_unused]] const float x = batch.x[i], y = batch.y[i];              \
      [[maybe_unused]] const std::uint32_t w = batch.w[i];                      \
      [[maybe_unused]] const std::uint32_t small = batch.small[i];              \
      [[maybe_unused]] const std::int32_t n = batch.n[i];                       \
      same(what, batch.first + static_cast<std::uint32_t>(i), found[i], alone); \
    }                                                                           \
  }

// What a table of three entries gives the second: of a number of each lane, then of numbers for all lanes.
double density(float p) {
  dist::Masses table;
  table.take(p, false);
  table.take(0.25F, true);
  table.take(math::mass(0.125F), true);
  return table.density();
}
hypgen::lanes::Double density(Float p) {
  dist::MassesLanes table;
  table.take(true, p, false);
  table.take(true, 0.25F, true);
  table.take(true, math::mass(0.125F), true);
  return table.density();
}

void compare(const Batch& batch) {
  SAME("sin", math::sin(batch.x), math::sin(x));
  SAME("cos", math::cos(batch.x), math::cos(x));
  SAME("atan2", math::atan2(batch.y, batch.x), math::atan2(y, x));
  SAME("sqrt", math::sqrt(batch.x), math::sqrt(x));
  SAME("log", math::log(batch.x), math::log(x));
  SAME("exp", math::exp(batch.x), math::exp(x));
  SAME("exp2", math::exp2(batch.x), math::exp2(x));
  SAME("hypot", math::hypot(batch.x, batch.y), math::hypot(x, y));
  SAME("normal_cdf", math::normal_cdf(batch.x), math::normal_cdf(x));
  SAME("floor", math::floor_to_int(batch.x, -9, 90), math::floor_to_int(x, -9, 90));
  SAME("ceil", math::ceil_to_int(batch.x, -9, 90), math::ceil_to_int(x, -9, 90));
  SAME("round", math::round_to_int(batch.x, -9, 90), math::round_to_int(x, -9, 90));
  SAME("clamp", math::clamp(batch.x, -1.0F, batch.y), math::clamp(x, -1.0F, y));
  // The sum of a step begins with +0, so that a -0 counts for nothing.
  SAME("to_fixed", math::to_fixed(batch.x) + 0.0, static_cast<double>(math::to_fixed(x)));
  SAME("to_fixed of an int", math::to_fixed(batch.n), static_cast<double>(math::to_fixed(n)));
  SAME("mass", math::mass(batch.x), math::mass(x));
  SAME("threshold", math::threshold(batch.x), math::threshold(x));
  SAME("a quotient", batch.n / 7, n / 7);
  SAME("a rest", batch.n % 25, n % 25);
  SAME("a quotient of words", batch.small / 25U, small / 25U);
  SAME("a rest of words", batch.small % 16U, small % 16U);
  SAME("a rest of large words", batch.w % 4000000007U, w % 4000000007U);
  SAME("a product", hypgen::lanes::multiplied(batch.w, Word(0xD2511F53U)).high,
       static_cast<std::uint32_t>(std::uint64_t{w} * 0xD2511F53U >> 32));
  SAME("uniform", dist::uniform(batch.w, 13), dist::uniform(w, 13));
  SAME("noisy", dist::noisy(batch.w, 2, batch.x, 5), dist::noisy(w, 2, x, 5));
  SAME("a table's density", density(batch.x), density(x));
  SAME("poisson", dist::poisson(batch.w, batch.x, {1, 30, true}, 0, 40),
       dist::poisson(w, x, {1, 30, true}, 0, 40));
  SAME("binomial", dist::binomial(batch.w, Int(20), batch.x, {}, 0, 20), dist::binomial(w, 20, x, {}, 0, 20));
  SAME("an exponential number", dist::ExponentialLanes(batch.x).draw(batch.w), dist::Exponential(x).draw(w));
  SAME("a normal number", (dist::NormalLanes{batch.x, batch.y}.draw(batch.w)), (dist::Normal{x, y}.draw(w)));
  SAME("a bin", (dist::BinsLanes(dist::NormalLanes{batch.x, 0.5F}, -6.0F, 26.0F, 64).draw(batch.w)),
       (dist::Bins(dist::Normal{x, 0.5F}, -6.0F, 26.0F, 64).draw(w)));
  SAME("a bin of each lane's ends",
       (dist::BinsLanes(dist::NormalLanes{batch.x, 0.5F}, -6.0F, batch.y, 8).draw(batch.w)),
       (dist::Bins(dist::Normal{x, 0.5F}, -6.0F, y, 8).draw(w)));
}

}  // namespace

int main() {
  for (int number = 0; number < kBatches; ++number) compare(Batch(static_cast<std::uint32_t>(number)));
  std::printf("%d lanes, %d differing\n", kLanes, differing);
  return differing == 0 ? 0 : 1;
}
