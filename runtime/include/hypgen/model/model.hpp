// What a generated model gives the runtime.
//
// A Model is a struct of static functions, deterministic and without globals; `Params`, `Fixed`, `State` and
// `History` are trivially copyable, and equal values of the last three have equal bytes. P, F, S and H stand
// for const references to them:
//
//   static constexpr int kActionCount, kVisibleCount, kVariableCount;
//   static constexpr bool kHasLower;                // `bound lower` is declared, or what the default policy
//   earns is known static constexpr bool kHasHistory;              // the policy remembers; otherwise derive
//   from NoHistory using Key = std::uint64_t;                      // of observations, or WideKey<N> struct
//   Params;                                  // tables derived at load included struct Fixed { std::uint32_t
//   words[..]; };      // once a scenario struct State { std::uint32_t words[..]; };      // the rest, packed
//   struct History { std::uint32_t words[..]; };    // what the policy knows of the past
//
//   void init_visible(P, D&, Fixed&, State&);       // zeroes first
//   void init_hidden(P, D&, Fixed&, State&);        // given the visible
//   void export_visible(F, S, std::int32_t* out);
//   void import_visible(const std::int32_t* in, Fixed&, State&);  // zeroes the rest
//   void export_state(F, S, std::int32_t* out);
//   bool is_legal(P, F, S, int action);             // reads no hidden variable
//   StepResult step(P, F, S, int action, D&, State& next);
//   Key observe(P, F, S, int action, D&, S next);
//   double filter(P, F, S, int action, const Key&, D&, State& next);  // 0: contradictory or terminal
//   int default_policy(P, F, S, H, D&);             // legal, or -1
//   float lower(P, F, S, H);
//   float upper(P, F, S);
//   float declared_upper(P, F, S);                  // only where `upper` may be less, by a derived table
//   float tail(P, F, S);
//   bool load(const ParamValues&, Params&, std::string& error);       // host only
//
//   void init_history(P, F, S, History&);           // reads visible variables only, as do the next two
//   void advance_history(P, F, S, int action, const Key&, S next, H, History& after);
//   void roll_history(P, F, S, int action, D&, S next, H, History& after);
//       // the same without a key: draws the observations that are kept, as `observe` would
//
// `D` is a draw source: `std::uint32_t word(std::uint32_t site, std::uint32_t index)`.
#pragma once

#include <cstdint>
#include <type_traits>

#include "hypgen/core/config.hpp"
#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/model/history.hpp"

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

// Whether the model has an upper bound of its own besides the declared one.
template <class M, class = void>
struct IsRelaxed : std::false_type {};
template <class M>
struct IsRelaxed<M, std::void_t<decltype(&M::declared_upper)>> : std::true_type {};

// Whether `bound lower` is declared, not what a table says that the default policy earns.
template <class M, class = void>
struct DeclaresLower : std::bool_constant<M::kHasLower> {};
template <class M>
struct DeclaresLower<M, std::enable_if_t<M::kLooksUpPolicy>> : std::false_type {};

// The number that a fixed-point sum stands for.
HYPGEN_FN double from_fixed_sum(std::int64_t sum) {
  return static_cast<double>(sum) * (1.0 / (std::int64_t{1} << kFixedBits));
}

}  // namespace hypgen
