// SPDX-License-Identifier: Apache-2.0
// The compile-time check of the contract in model.hpp. A solver, the exact solver and a GPU's part each check
// the model that they are made of, so that a text names what is missing.
#pragma once

#include <cstdint>
#include <string>
#include <type_traits>

#include "hypgen/model/descriptor.hpp"
#include "hypgen/model/model.hpp"
#include "hypgen/model/part.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

namespace contract {

// Whether `Member<M>` is well-formed. Each alias below is well-formed for a model that has some members.
template <template <class> class Member, class M, class = void>
struct HasMember : std::false_type {};
template <template <class> class Member, class M>
struct HasMember<Member, M, std::void_t<Member<M>>> : std::true_type {};
template <template <class> class Member, class M>
constexpr bool kHas = HasMember<Member, M>::value;

template <int value>
struct Number;
template <bool value>
struct Truth;
template <class Result, class Found>
using Returns = std::enable_if_t<std::is_same_v<Result, Found>>;

// Arguments of a model's functions, by the letters of model.hpp: declared for `decltype`, never defined.
template <class M>
const typename M::Params& P();
template <class M>
const typename M::Fixed& F();
template <class M>
const typename M::State& S();
template <class M>
const typename M::History& H();
template <class M>
const typename M::Key& key();
PhiloxDraws& draws();
template <class T>
T& to();

template <class M>
using Types = std::void_t<typename M::Params, typename M::Fixed, typename M::State, typename M::Key>;
template <class T>
constexpr bool kIsPacked = std::is_empty_v<T> || (std::is_trivially_copyable_v<T> && sizeof(T) % 4 == 0 &&
                                                  std::has_unique_object_representations_v<T>);
template <class M>
using Counts = std::void_t<Number<M::kActionCount>, Number<M::kVisibleCount>, Number<M::kVariableCount>>;
template <class M>
using Load =
    Returns<bool, decltype(M::load(to<const ParamValues>(), to<typename M::Params>(), to<std::string>()))>;

template <class M>
using InitVisible =
    decltype(M::init_visible(P<M>(), draws(), to<typename M::Fixed>(), to<typename M::State>()));
template <class M>
using InitHidden =
    decltype(M::init_hidden(P<M>(), draws(), to<typename M::Fixed>(), to<typename M::State>()));
template <class M>
using ExportVisible = decltype(M::export_visible(F<M>(), S<M>(), to<std::int32_t*>()));
template <class M>
using ImportVisible =
    decltype(M::import_visible(to<const std::int32_t*>(), to<typename M::Fixed>(), to<typename M::State>()));
template <class M>
using ExportState = decltype(M::export_state(F<M>(), S<M>(), to<std::int32_t*>()));

template <class M>
using IsLegal = Returns<bool, decltype(M::is_legal(P<M>(), F<M>(), S<M>(), 0))>;
template <class M>
using Step =
    Returns<StepResult, decltype(M::step(P<M>(), F<M>(), S<M>(), 0, draws(), to<typename M::State>()))>;
template <class M>
using Observe = Returns<typename M::Key, decltype(M::observe(P<M>(), F<M>(), S<M>(), 0, draws(), S<M>()))>;
template <class M>
using Filter =
    Returns<double,
            decltype(M::filter(P<M>(), F<M>(), S<M>(), 0, key<M>(), draws(), to<typename M::State>()))>;

template <class M>
using ObservationDensity =
    Returns<double, decltype(M::observation_density(P<M>(), F<M>(), S<M>(), 0, key<M>(), draws(), S<M>()))>;

template <class M>
using Upper = Returns<float, decltype(M::upper(P<M>(), F<M>(), S<M>()))>;
template <class M>
using Tail = Returns<float, decltype(M::tail(P<M>(), F<M>(), S<M>()))>;
template <class M>
using Lower =
    std::void_t<Truth<M::kHasLower>, Returns<float, decltype(M::lower(P<M>(), F<M>(), S<M>(), H<M>()))>>;

template <class M>
using Remembers = std::void_t<Truth<M::kHasHistory>, typename M::History>;
template <class M>
using MovesHistory = std::void_t<decltype(M::init_history(P<M>(), F<M>(), S<M>(), to<typename M::History>())),
                                 decltype(M::advance_history(P<M>(), F<M>(), S<M>(), 0, key<M>(), S<M>(),
                                                             H<M>(), to<typename M::History>())),
                                 decltype(M::roll_history(P<M>(), F<M>(), S<M>(), 0, draws(), S<M>(), H<M>(),
                                                          to<typename M::History>()))>;
template <class M>
using DefaultPolicy = Returns<int, decltype(M::default_policy(P<M>(), F<M>(), S<M>(), H<M>(), draws()))>;

template <class M>
using Factored = std::void_t<Truth<M::kFactored>, Number<M::kExactUnits>, typename M::Posterior>;
template <class M>
using MovesPosterior =
    std::void_t<decltype(M::init_posterior(P<M>(), F<M>(), S<M>(), to<typename M::Posterior>())),
                Returns<bool, decltype(M::advance_posterior(P<M>(), F<M>(), S<M>(), 0, key<M>(), S<M>(),
                                                            to<const typename M::Posterior>(),
                                                            to<typename M::Posterior>()))>>;
template <class M>
using InitLikelihood = Returns<double, decltype(M::init_likelihood(P<M>(), F<M>(), S<M>()))>;
template <class M>
using InitExplains =
    Returns<bool, decltype(M::init_posterior(P<M>(), F<M>(), S<M>(), to<typename M::Posterior>()))>;
template <class M>
using WeighStart = Returns<double, decltype(M::weigh_start(0, P<M>(), F<M>(), S<M>()))>;
template <class M>
using Units =
    std::void_t<Number<M::kParticleUnits>, Returns<int, decltype(M::unit_of(0))>,
                decltype(M::advance_visible(P<M>(), F<M>(), S<M>(), 0, key<M>(), to<typename M::State>()))>;
template <class M>
using ExactUnits =
    std::void_t<Returns<int, decltype(M::unit_size(0))>,
                Returns<double, decltype(M::probability(to<const typename M::Posterior>(), 0, 0))>,
                decltype(M::put_unit(0, 0, to<typename M::Fixed>(), to<typename M::State>()))>;
template <class M>
using ParticleUnits = std::void_t<
    typename M::Evidence, Number<M::kUnitValues>,
    decltype(M::see(P<M>(), F<M>(), S<M>(), 0, key<M>(), to<typename M::Evidence>())),
    decltype(M::draw_unit(0, P<M>(), draws(), to<typename M::Fixed>(), to<typename M::State>())),
    Returns<double, decltype(M::move_unit(0, P<M>(), F<M>(), S<M>(), 0, to<const typename M::Evidence>(),
                                          draws(), to<typename M::State>()))>,
    decltype(M::copy_unit(0, F<M>(), S<M>(), to<typename M::Fixed>(), to<typename M::State>())),
    Returns<int, decltype(M::export_unit(0, F<M>(), S<M>(), to<double*>()))>>;

template <class M>
using HasTracking = typename M::Tracking;
template <class M>
using Redrawn = std::void_t<Number<M::kRedrawnWords>, Number<M::kRedrawnSingles>,
                            Returns<int, decltype(M::redrawn_word(std::uint32_t{}, std::uint32_t{}))>,
                            Returns<bool, decltype(M::Tracking::is_word_read(F<typename M::Tracking>(), 0))>>;

template <class M>
using HasHiddenValues = Number<M::kHiddenValues>;
template <class M>
using MovesValues =
    std::void_t<Returns<std::int32_t, decltype(M::hidden_size(0))>,
                Returns<std::int32_t, decltype(M::hidden_value(F<M>(), 0))>,
                decltype(M::put_hidden(to<typename M::Fixed>(), 0, std::int32_t{})),
                Returns<double, decltype(M::init_density(P<M>(), F<M>(), S<M>()))>,
                Returns<double, decltype(M::weigh_hidden(P<M>(), F<M>(), S<M>(), 0, key<M>(), S<M>()))>>;

template <class M>
using Parts = std::void_t<Number<M::kStages>, Number<M::kMaxWarps>,
                          decltype(M::step_stage(0, P<M>(), F<M>(), S<M>(), 0, draws(),
                                                 to<typename M::State>(), Part{})),
                          decltype(M::step_rewards(P<M>(), F<M>(), S<M>(), 0, draws(), S<M>(), Part{},
                                                   to<std::int64_t>(), to<bool>())),
                          Returns<StepResult, decltype(M::step_end(P<M>(), F<M>(), S<M>(), 0, draws(), S<M>(),
                                                                   std::int64_t{}, false))>>;

// What a factored belief calls; nothing of a model without one.
template <class M, bool is_factored>
struct IfFactored {};
template <class M>
struct IfFactored<M, true> {
  static_assert(kHas<Units, M>,
                "model contract: a model with kFactored lacks kParticleUnits, unit_of or advance_visible");
  static_assert(M::kExactUnits == 0 || kHas<ExactUnits, M>,
                "model contract: a model with exact units lacks unit_size, probability or put_unit");
  static_assert(M::kParticleUnits == 0 || kHas<ParticleUnits, M>,
                "model contract: a model with particle units lacks Evidence, kUnitValues, see, draw_unit, "
                "move_unit, copy_unit or export_unit");
  static_assert(!SeesFirst<M>::value || kHas<InitExplains, M>,
                "model contract: init_posterior of a model with init_likelihood does not return a bool");
  static_assert(!SeesFirst<M>::value || M::kParticleUnits == 0 || kHas<WeighStart, M>,
                "model contract: a model with init_likelihood and particle units lacks weigh_start");
};

// What every model has besides its types.
template <class M>
struct Functions {
  static_assert(kIsPacked<typename M::Fixed>, "model contract: Fixed is not made of 32-bit words alone");
  static_assert(kIsPacked<typename M::State>, "model contract: State is not made of 32-bit words alone");
  static_assert(kHas<Counts, M>, "model contract: kActionCount, kVisibleCount or kVariableCount is missing");
  static_assert(kHas<Load, M>, "model contract: load is missing or has another signature");
  static_assert(kHas<InitVisible, M>, "model contract: init_visible is missing or has another signature");
  static_assert(kHas<InitHidden, M>, "model contract: init_hidden is missing or has another signature");
  static_assert(kHas<ExportVisible, M>, "model contract: export_visible is missing or has another signature");
  static_assert(kHas<ImportVisible, M>, "model contract: import_visible is missing or has another signature");
  static_assert(kHas<ExportState, M>, "model contract: export_state is missing or has another signature");
  static_assert(!SeesFirst<M>::value || kHas<InitLikelihood, M>,
                "model contract: init_likelihood has another signature");
  static_assert(kHas<IsLegal, M>, "model contract: is_legal is missing or has another signature");
  static_assert(kHas<Step, M>, "model contract: step is missing or has another signature");
  static_assert(kHas<Observe, M>, "model contract: observe is missing or has another signature");
  static_assert(kHas<Filter, M>, "model contract: filter is missing or has another signature");
  static_assert(kHas<ObservationDensity, M>,
                "model contract: observation_density is missing or has another signature");
  static_assert(kHas<Upper, M>, "model contract: upper is missing or has another signature");
  static_assert(kHas<Tail, M>, "model contract: tail is missing or has another signature");
  static_assert(kHas<Remembers, M>,
                "model contract: kHasHistory or History is missing (a model may derive from NoHistory)");
  static_assert(kHas<MovesHistory, M>,
                "model contract: init_history, advance_history or roll_history is missing or has another "
                "signature (a model may derive from NoHistory)");
  static_assert(kHas<DefaultPolicy, M>, "model contract: default_policy is missing or has another signature");
  static_assert(kHas<Lower, M>, "model contract: kHasLower or lower is missing or has another signature");
  static_assert(kHas<Factored, M>,
                "model contract: kFactored, kExactUnits or Posterior is missing (a model may derive from "
                "NotFactored)");
  static_assert(kHas<MovesPosterior, M>,
                "model contract: init_posterior or advance_posterior is missing or has another signature (a "
                "model may derive from NotFactored)");
  static_assert(!kHas<HasTracking, M> || kHas<Redrawn, M>,
                "model contract: a model with Tracking lacks kRedrawnWords, kRedrawnSingles, redrawn_word or "
                "Tracking::is_word_read");
  static_assert(!kHas<HasHiddenValues, M> || kHas<MovesValues, M>,
                "model contract: a model with kHiddenValues lacks hidden_size, hidden_value, put_hidden, "
                "init_density or weigh_hidden");
};

template <class M>
constexpr bool is_factored() {
  if constexpr (kHas<Factored, M>) return M::kFactored;
  return false;
}

}  // namespace contract

// Fails to compile, with a text that names what is missing, unless M is a model. `kHolds` is true.
template <class M, bool has_types = contract::kHas<contract::Types, M>>
struct ModelContract : contract::Functions<M>, contract::IfFactored<M, contract::is_factored<M>()> {
  static constexpr bool kHolds = true;
};
template <class M>
struct ModelContract<M, false> {
  static_assert(contract::kHas<contract::Types, M>,
                "model contract: the type Params, Fixed, State or Key is missing");
  static constexpr bool kHolds = true;
};

// The same for a model that is compiled for GPUs too.
template <class M>
struct DeviceModelContract : ModelContract<M> {
  static_assert(contract::kHas<contract::Parts, M>,
                "model contract: a model for GPUs lacks kStages, kMaxWarps, step_stage, step_rewards or "
                "step_end");
};

}  // namespace hypgen
