// SPDX-License-Identifier: Apache-2.0
// The contract between a model and the runtime: all that the runtime reads and calls of a model.
//
// A model is a struct of types, constants and static functions. It has no globals, and its functions are
// deterministic. hypgen generates one from each .pomdp file. `ModelContract` in model_contract.hpp checks at
// compile time that a struct has the members below. All are required but those that a section calls optional.
//
// Terms:
// - A *variable* is one number of the model's state. A variable is *visible* if the agent knows its value
//   at all times, otherwise *hidden*.
// - *Exported* values are int32: whole numbers as they are, bools as 0 and 1, enums as codes, floats as the
//   bits of a float32. Variables come in the order of their declaration, arrays row by row.
// - A *scenario* is an initial state and the random numbers of one possible future.
// - A *draw source* D has `std::uint32_t word(std::uint32_t site, std::uint32_t index)`, the uniform random
//   word of that name. A *site* is a place of the model that draws; an *index* tells its draws apart. The
//   same name has the same word, so equal states with equal draws have equal successors.
// - P, F, S and H stand for `const Params&`, `const Fixed&`, `const State&` and `const History&`.
//
// Types. Fixed, State and History are trivially copyable, and equal values of them have equal bytes.
//   struct Params;   // what a parameter file may set, and tables that `load` derives
//   struct Fixed;    // the variables that no step changes, packed into 32-bit words; kept once a scenario
//   struct State;    // all other variables, packed in the same way
//   struct History;  // what the default policy remembers of the past
//   using Key;       // of an observation: std::uint64_t or WideKey<N> (key.hpp)
//
// Constants.
//   int kActionCount;    // actions are numbered 0 .. kActionCount - 1; an action of several agents is one
//   int kVisibleCount;   // visible variables
//   int kVariableCount;  // all variables
//   float kLeastReward;  // optional: no step earns less
//   int kRewardBits;     // optional: fraction bits of rewards in fixed point, kFixedBits without it
//   bool kRewardsFit;    // optional: no step's sum of rewards leaves its range
//   bool kKeyHoldsState;    // optional: visible variables are digits of the key
//   bool kKeyIsContinuous;  // optional: a digit of the key has a continuous law, so that keys hardly ever repeat
//
// Params. On the host only.
//   bool load(const ParamValues&, Params&, std::string& error);  // false: bad values, named in `error`
//
// Initial state. `init_visible` comes first and zeroes both blocks. `init_hidden` leaves what is visible. Both
// get the same draws: `init_visible` draws hidden variables too where visible ones depend on them. Each value goes
// through `first_value` (start_values.hpp), so that a world may start where it is told to.
//   void init_visible(P, D&, Fixed&, State&);
//   void init_hidden(P, D&, Fixed&, State&);
//   double init_likelihood(P, F, S);  // optional: of the visible variables that depend on hidden ones, their
//                                     // probability at the start given all others
//   void export_visible(F, S, std::int32_t* out);                 // kVisibleCount values
//   void import_visible(const std::int32_t* in, Fixed&, State&);  // the same ones; zeroes all others
//   void export_state(F, S, std::int32_t* out);                   // kVariableCount values
//
// Step and observation. `next` holds the state after the step. `observe`, `filter` and `observation_density` are
// for steps that do not end the episode.
//   bool is_legal(P, F, S, int action);                              // reads no hidden variable
//   StepResult step(P, F, S, int action, D&, State& next);
//   Key observe(P, F, S, int action, D&, S next);                    // draws what the agent sees
//   double filter(P, F, S, int action, const Key&, D&, State& next);
//       // draws `next` given what was seen of it, and returns the likelihood of all that was seen, a density
//       // where some of it has a continuous law; 0: the key contradicts the state, or the step ends the episode
//   double observation_density(P, F, S, int action, const Key&, D&, S next);
//       // of the key's observations, given `next`, which `step` made with the same draws: a product of
//       // probabilities, and of densities per unit for continuous laws. 0 where a visible variable of the key is
//       // not that of `next`
//
// Bounds on the discounted sum of rewards from a state on, in the rewards' unit. `lower` always exists, and
// counts only if kHasLower.
//   float upper(P, F, S);           // no policy earns more, even if it knows the state
//   float tail(P, F, S);            // what the default policy is taken to earn beyond the depth limit
//   float lower(P, F, S, H);        // replaces a rollout of the default policy
//   bool kHasLower;
//   bool kLooksUpPolicy;            // optional; true: `lower` is a table of what the default policy earns,
//                                   // and the model declares no lower bound
//   float declared_upper(P, F, S);  // optional: the model's own bound, where `upper` may be tighter
//
// Default policy and history. The functions read no hidden variable. A model derives from NoHistory
// (history.hpp) if its policy remembers nothing.
//   int default_policy(P, F, S, H, D&);                                           // legal; -1: no action is
//   bool kHasHistory;                                                             // the policy remembers
//   void init_history(P, F, S, History&);                                         // at the initial state
//   void advance_history(P, F, S, int action, const Key&, S next, H, History& after);  // what was seen: Key
//   void roll_history(P, F, S, int action, D&, S next, H, History& after);        // draws what was seen
//
// Factored belief. A model derives from NotFactored (belief/posterior.hpp) if its belief is no product. A
// *unit* is a group of hidden variables that is independent of all others given what the agent sees. A unit
// of few values has an exact posterior, any other has particles. Units are numbered from 0, exact ones first.
//   bool kFactored;
//   int kExactUnits;
//   struct Posterior;                                                  // of all exact units
//   void init_posterior(P, F, S, Posterior& after);  // with init_likelihood bool; false: no value of some unit
//                                                    // explains what is visible
//   bool advance_posterior(P, F, S, int action, const Key&, S next, const Posterior& now, Posterior& after);
//       // false: no value of some unit explains the key
//   Required if kFactored:
//   int kParticleUnits;
//   void advance_visible(P, F, S, int action, const Key&, State& next);  // moves visible variables alone
//   int unit_of(int variable);                                           // -1: visible
//   Required if kFactored and kExactUnits > 0. A unit's values are numbered from 0.
//   int unit_size(int unit);                                             // how many values
//   double probability(const Posterior&, int unit, std::int32_t value);
//   void put_unit(int unit, std::int32_t value, Fixed&, State&);         // writes the unit's variables
//   Required if kFactored and kParticleUnits > 0. `unit` counts from 0 among the units with particles.
//   struct Evidence;     // what all particles of a step share; its member `next` has the visible variables
//   int kUnitValues;                                                   // numbers that export_unit writes at most
//   void see(P, F, S, int action, const Key&, Evidence&);
//   void draw_unit(int unit, P, D&, Fixed&, State&);                   // the unit's part of init_hidden
//   double move_unit(int unit, P, F, S, int action, const Evidence&, D&, State& next);
//       // the unit's part of `filter`: draws its variables, and gives the likelihood of what was seen of it
//   void copy_unit(int unit, F from_fixed, S from_state, Fixed&, State&);
//   int export_unit(int unit, F, S, double* out);                      // the unit's variables, and how many
//   double weigh_start(int unit, P, F, S);  // with init_likelihood: the unit's part of it
//
// Redraw of particles (belief/redraw.hpp). Optional, all or none: particles draw again what nothing has read.
//   using Tracking;                                          // the same model, which notes reads of Fixed
//   int kRedrawnWords;                                       // random words that may be drawn again
//   int kRedrawnSingles;                                     // of these, words of single values: the first
//   int redrawn_word(std::uint32_t site, std::uint32_t index);  // the word's number; -1: not such a word
//   bool Tracking::is_word_read(const Tracking::Fixed&, int word);
//
// Moves of values (belief/value_moves.hpp). Optional, all or none: where all hidden variables are fixed.
//   int kHiddenValues;                                          // entries of hidden variables, numbered from 0
//   std::int32_t hidden_size(int entry);                        // how many values it may have
//   std::int32_t hidden_value(F, int entry);                    // which of them it has, numbered from 0
//   void put_hidden(Fixed&, int entry, std::int32_t value);
//   double init_density(P, F, S);                               // the probability of hidden values at the start
//   double weigh_hidden(P, F, S, int action, const Key&, S next);  // what `filter` returns; `next` is given
//
// Parts of a step (verify/schedule.hpp, cuda/steppers.cuh). Optional on the host, required for a GPU. The
// warps of a block share a step: stage by stage, and within a stage by numbers (part.hpp).
//   int kStages;
//   int kMaxWarps;                                           // more would find nothing to do
//   void step_stage(int stage, P, F, S, int action, D&, State& next, Part);
//       // one warp's updates of a stage; before the first stage `next` equals the state. Within a stage no
//       // warp reads or writes a word of `next` that another warp writes
//   void step_rewards(P, F, S, int action, D&, S next, Part, std::int64_t& sum, bool& error);
//       // adds one warp's reward terms in fixed point, not saturated; `error` becomes true for a NaN
//   StepResult step_end(P, F, S, int action, D&, S next, std::int64_t sum, bool error);
//       // what `step` would return, from the whole sum
#pragma once

#include <cstdint>
#include <type_traits>

#include "hypgen/core/config.hpp"
#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/model/history.hpp"

namespace hypgen {

// Rewards and returns are summed as int64 in fixed point, so their order does not matter.
using math::kFixedBits;

// The fraction bits of a model's rewards in fixed point.
template <class M, class = void>
inline constexpr int kRewardBits = kFixedBits;
template <class M>
inline constexpr int kRewardBits<M, std::void_t<decltype(M::kRewardBits)>> = M::kRewardBits;

// The outcome of a step, but for the next state.
struct StepResult {
  std::int64_t reward;  // in fixed point
  bool terminal;        // the episode ends
  bool success;         // `success when` held
  bool error;           // a reward term was NaN

  // A model error: the reward is not known.
  HYPGEN_FN bool is_broken() const { return error || math::is_saturated(reward); }
};

// Whether no step's sum of rewards leaves its range.
template <class M, class = void>
inline constexpr bool kRewardsFit = false;
template <class M>
inline constexpr bool kRewardsFit<M, std::void_t<decltype(M::kRewardsFit)>> = M::kRewardsFit;

// `StepResult::is_broken` for the steps of a model, without tests that its rewards never fail.
template <class M>
HYPGEN_FN bool is_broken(const StepResult& result) {
  if constexpr (kRewardsFit<M>) return result.error;
  return result.is_broken();
}

// Whether visible variables are digits of the key, so that what was seen may contradict a state after the step.
template <class M, class = void>
inline constexpr bool kKeyHoldsState = false;
template <class M>
inline constexpr bool kKeyHoldsState<M, std::void_t<decltype(M::kKeyHoldsState)>> = M::kKeyHoldsState;

// Whether a digit of the key has a continuous law, so that keys hardly ever repeat.
template <class M, class = void>
inline constexpr bool kKeyIsContinuous = false;
template <class M>
inline constexpr bool kKeyIsContinuous<M, std::void_t<decltype(M::kKeyIsContinuous)>> = M::kKeyIsContinuous;

// Whether `upper` may be tighter than the bound that the model declares.
template <class M, class = void>
struct IsRelaxed : std::false_type {};
template <class M>
struct IsRelaxed<M, std::void_t<decltype(&M::declared_upper)>> : std::true_type {};

// Whether what the agent sees at the start tells of hidden variables.
template <class M, class = void>
struct SeesFirst : std::false_type {};
template <class M>
struct SeesFirst<M, std::void_t<decltype(&M::init_likelihood)>> : std::true_type {};

// Whether the model declares a lower bound. One that is looked up from a table is not declared.
template <class M, class = void>
struct DeclaresLower : std::bool_constant<M::kHasLower> {};
template <class M>
struct DeclaresLower<M, std::enable_if_t<M::kLooksUpPolicy>> : std::false_type {};

// 1 in a model of the usual scale of rewards, otherwise what that 1 would be: absolute tolerances are meant
// for the usual scale, and are multiplied by it.
HYPGEN_FN double reward_scale(int reward_bits) { return math::power_of_two(kFixedBits - reward_bits); }

// The number that a fixed-point sum of so many fraction bits stands for.
template <int kBits = kFixedBits>
HYPGEN_FN double from_fixed_sum(std::int64_t sum) {
  constexpr double kUnit = math::power_of_two(-kBits);
  return static_cast<double>(sum) * kUnit;
}

}  // namespace hypgen
