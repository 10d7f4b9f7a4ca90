// What a generated model gives the runtime.
//
// A Model is a struct of static functions, deterministic and without globals; `Params`, `Fixed` and `State`
// are trivially copyable, and equal values of `Fixed` and `State` have equal bytes:
//
//   static constexpr int kActionCount, kVisibleCount, kVariableCount;
//   static constexpr bool kHasLower;                // `bound lower` is declared
//   using Key = std::uint64_t;                      // of observations, or WideKey<N>
//   struct Params;                                  // tables derived at load included
//   struct Fixed { std::uint32_t words[..]; };      // once a scenario
//   struct State { std::uint32_t words[..]; };      // the rest, packed
//
//   template <class D> static void init_visible(const Params&, D&, Fixed&, State&);  // zeroes first
//   template <class D> static void init_hidden(const Params&, D&, Fixed&, State&);   // given the visible
//   ones static void export_visible(const Fixed&, const State&, std::int32_t* out); static void
//   import_visible(const std::int32_t* in, Fixed&, State&);              // zeroes the rest static void
//   export_state(const Fixed&, const State&, std::int32_t* out); static bool is_legal(const Params&, const
//   Fixed&, const State&, int action);     // reads no hidden variable template <class D> static StepResult
//   step(const Params&, const Fixed&, const State&, int action, D&,
//                                             State& next);
//   template <class D> static Key observe(const Params&, const Fixed&, const State&, int action, D&,
//                                         const State& next);
//   template <class D> static double filter(const Params&, const Fixed&, const State&, int action, const
//   Key&, D&,
//                                           State& next);        // 0: contradictory or terminal
//   template <class D> static int default_policy(const Params&, const Fixed&, const State&, D&);  // legal or
//   -1 static float upper(const Params&, const Fixed&, const State&);    // and lower, tail static bool
//   load(const ParamValues&, Params&, std::string& error);                            // host only
//
// `D` is a draw source: `std::uint32_t word(std::uint32_t site, std::uint32_t index)`.
#pragma once

#include <cstdint>

#include "hypgen/config.hpp"
#include "hypgen/math.hpp"

namespace hypgen {

// Rewards and returns are summed as int64 with this many fraction bits, so that the order cannot matter.
using math::kFixedBits;

// What a step earns, and whether it ended the episode.
struct StepResult {
  std::int64_t reward;  // fixed point
  bool terminal;
  bool success;  // `success when` held
  bool error;    // a reward term was NaN
};

// The number that a fixed-point sum stands for.
HYPGEN_FN double from_fixed_sum(std::int64_t sum) {
  return static_cast<double>(sum) * (1.0 / (std::int64_t{1} << kFixedBits));
}

}  // namespace hypgen
