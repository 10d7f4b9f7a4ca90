// SPDX-License-Identifier: Apache-2.0
// A belief that is a product of posteriors, one for each unit. A unit is a group of hidden variables that is
// independent of all others: an element of the model, or one member of a family. A unit of few values has an
// exact posterior, any other has particles.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/belief/particle_filter.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen {

// What the particle filter calls of the units without an exact posterior.
template <class M>
struct ParticleUnits {
  using Params = typename M::Params;
  using Fixed = typename M::Fixed;
  using State = typename M::State;
  using Key = typename M::Key;
  using Evidence = typename M::Evidence;
  static constexpr int kUnits = M::kParticleUnits;
  static constexpr int kValues = M::kUnitValues;
  static constexpr int kFirstWords = 256;
  static constexpr bool kCountsApart = false;
  static constexpr bool kRedraws = false;
  static constexpr bool kMovesValues = false;

  static void see(const Params& params, const Fixed& fixed, const State& state, int action, const Key& key,
                  Evidence& seen) {
    M::see(params, fixed, state, action, key, seen);
  }
  static constexpr bool kSeesFirst = SeesFirst<M>::value;
  static double weigh_start(const Params& params, int unit, const Fixed& fixed, const State& state) {
    if constexpr (kSeesFirst) return M::weigh_start(unit, params, fixed, state);
    return 1.0;
  }
  static const State& visible(const Evidence& seen) { return seen.next; }
  template <class D>
  static void draw(const Params& params, D& draws, int unit, Fixed& fixed, State& state) {
    M::draw_unit(unit, params, draws, fixed, state);
  }
  template <class D>
  static double move(const Params& params, const Fixed& fixed, const State& state, int action,
                     const Evidence& seen, D& draws, int unit, State& next) {
    return M::move_unit(unit, params, fixed, state, action, seen, draws, next);
  }
  static void copy(int unit, const Fixed& fixed, const State& state, Fixed& to_fixed, State& to_state) {
    M::copy_unit(unit, fixed, state, to_fixed, to_state);
  }
  static int values(int unit, const Fixed& fixed, const State& state, double* out) {
    return M::export_unit(unit, fixed, state, out);
  }
};

// Stands for the filter where all units have exact posteriors.
struct NoParticles {
  template <class... Parts>
  NoParticles(const Parts&...) {}
  template <class... Parts>
  bool init(const Parts&...) {
    return true;
  }
  template <class... Parts>
  bool weigh(const Parts&...) {
    return true;
  }
  template <class Part>
  int restart(const Part&) {
    return 0;
  }
  void accept() {}
  void use(Workers*) {}
  std::vector<UnitHealth> health() const { return {}; }
  bool has_resampled() const { return false; }
};

template <class M, bool kNone>
struct FilterOf {
  using Type = ParticleFilter<ParticleUnits<M>>;
};
template <class M>
struct FilterOf<M, true> {
  using Type = NoParticles;
};

// M::unit_of numbers the units: exact ones first, then those with particles.
template <class M>
class FactoredBelief final : public Belief {
 public:
  FactoredBelief(const typename M::Params& params, std::uint64_t seed, std::size_t particles)
      : params_(params),
        seed_(seed),
        size_(particles),
        filter_(params, particles),
        trial_fixed_(kTrials),
        trial_states_(kTrials) {
    reserve(trials_, kTrials);
  }

  void use(Workers* workers) override { filter_.use(workers); }

  Status init(const std::int32_t* visible, std::uint64_t run) override {
    key_ = derive(seed_, StreamKind::kBelief, run);
    step_ = 0;
    M::import_visible(visible, fixed_, state_);
    M::init_history(params_, fixed_, state_, history_);
    if constexpr (SeesFirst<M>::value) {
      const bool is_possible = M::init_posterior(params_, fixed_, state_, posterior_);
      return filter_.init(key_, fixed_, state_) && is_possible ? Status::kOk : Status::kImpossibleObservation;
    } else {
      M::init_posterior(params_, fixed_, state_, posterior_);
      filter_.init(key_, fixed_, state_);
      return Status::kOk;
    }
  }

  Status update(int action, KeyWords words) override {
    const auto key = key_from<typename M::Key>(words);
    typename M::State next;
    typename M::Posterior after;
    M::advance_visible(params_, fixed_, state_, action, key, next);
    if (!M::advance_posterior(params_, fixed_, state_, action, key, next, posterior_, after)) {
      return ends_surely(action) ? Status::kAllParticlesTerminal : Status::kImpossibleObservation;
    }
    if (!filter_.weigh(state_, action, key, kRedraws)) {
      if (ends_surely(action)) return Status::kAllParticlesTerminal;
      return filter_.has_resampled() ? Status::kDepletedBelief : Status::kImpossibleObservation;
    }
    move_on(action, key, next, after);
    return Status::kOk;
  }

  // A unit keeps its posterior if all its values contradict the observation. If all its particles do, it starts
  // again from the initial law given the observation. Where that contradicts it too, they keep their weights.
  void propagate(int action, KeyWords words) override {
    const auto key = key_from<typename M::Key>(words);
    typename M::State next;
    typename M::Posterior after;
    M::advance_visible(params_, fixed_, state_, action, key, next);
    M::advance_posterior(params_, fixed_, state_, action, key, next, posterior_, after);
    if (!filter_.weigh(state_, action, key, 0)) filter_.restart(state_);
    move_on(action, key, next, after);
  }

  void reserve(ScenarioBuffer& buffer, std::size_t capacity) const override {
    buffer.reserve(sizeof(typename M::Fixed), sizeof(typename M::State), sizeof(typename M::History),
                   capacity);
    if (capacity > order_.size()) {
      order_.resize(capacity);
      picks_.resize(capacity * kUnits);
    }
  }

  // Draws each unit by systematic sampling, and joins the draws of different units at random.
  void sample(StreamKey key, std::uint32_t first, std::size_t count, ScenarioBuffer& out) const override {
    out.clear(first);
    out.set_history(history_);
    for (int unit = 0; unit < kUnits; ++unit) {
      PhiloxDraws draws(key, first, static_cast<std::uint32_t>(unit));
      shuffle(draws, count);
      int* const picks = picks_.data() + static_cast<std::size_t>(unit) * count;
      choose([&](int i) { return weight(unit, i); }, values_of(unit), draws.word(kSampleSite, 0), count,
             [&](std::size_t i, int pick) { picks[order_[i]] = pick; });
    }
    for (std::size_t i = 0; i < count; ++i) {
      typename M::Fixed fixed = fixed_;
      typename M::State state = state_;
      for (int unit = 0; unit < kUnits; ++unit) {
        put(unit, picks_[static_cast<std::size_t>(unit) * count + i], fixed, state);
      }
      out.push(fixed, state);
    }
  }

  bool is_legal(int action) const override { return M::is_legal(params_, fixed_, state_, action); }

  int default_action(StreamKey key) const override {
    PhiloxDraws draws(key, 0, 0);
    return M::default_policy(params_, fixed_, state_, history_, draws);
  }

  void each_value(int variable, const TakeValue& take) const override {
    const int unit = M::unit_of(variable);
    if (unit < 0) return take(exported(variable, fixed_, state_), 1.0);
    for (int i = 0; i < values_of(unit); ++i) {
      typename M::Fixed fixed = fixed_;
      typename M::State state = state_;
      put(unit, i, fixed, state);
      take(exported(variable, fixed, state), weight(unit, i));
    }
  }

  // A sample of `size()` joint states.
  void export_particles(ScenarioBuffer& particles, std::vector<double>& weights) const override {
    reserve(particles, size_);
    sample(derive(seed_, StreamKind::kBelief, UINT64_MAX), 0, size_, particles);
    weights.assign(size_, 1.0 / static_cast<double>(size_));
  }

  bool import_particles(const ScenarioBuffer&, const std::vector<double>&) override { return false; }

  std::vector<UnitHealth> health() const override { return filter_.health(); }

  // The least of all units with particles; `size()` where all posteriors are exact.
  double effective_sample_size() const override {
    double least = static_cast<double>(size_);
    if constexpr (M::kParticleUnits > 0) {
      for (int unit = 0; unit < M::kParticleUnits; ++unit)
        least = std::min(least, filter_.effective_size(unit));
    }
    return least;
  }

  std::size_t size() const override { return size_; }

 private:
  static constexpr std::uint32_t kRedraws = 16;  // of particles that all contradict an observation
  static constexpr int kUnits = M::kExactUnits + M::kParticleUnits;
  static constexpr std::size_t kTrials = 256;  // joint states on which ends_surely tries an action

  static std::int32_t exported(int variable, const typename M::Fixed& fixed, const typename M::State& state) {
    std::int32_t values[M::kVariableCount];
    M::export_state(fixed, state, values);
    return values[variable];
  }

  // The number of a unit's joint values or particles.
  int values_of(int unit) const {
    if constexpr (M::kExactUnits > 0) {
      if (unit < M::kExactUnits) return M::unit_size(unit);
    }
    if constexpr (M::kParticleUnits > 0) return filter_.count(unit - M::kExactUnits);
    return 0;
  }

  // The probability of joint value i of a unit, or the weight of its particle i.
  double weight(int unit, int i) const {
    if constexpr (M::kExactUnits > 0) {
      if (unit < M::kExactUnits) return M::probability(posterior_, unit, i);
    }
    if constexpr (M::kParticleUnits > 0) return filter_.weight(unit - M::kExactUnits, i);
    return 0.0;
  }

  // Writes joint value i of a unit, or the unit's variables in particle i.
  void put(int unit, int i, typename M::Fixed& fixed, typename M::State& state) const {
    if constexpr (M::kExactUnits > 0) {
      if (unit < M::kExactUnits) return M::put_unit(unit, i, fixed, state);
    }
    if constexpr (M::kParticleUnits > 0) filter_.put(unit - M::kExactUnits, i, fixed, state);
  }

  // Makes the visible state `next`, the posteriors `after` and the particles that were weighed the belief.
  void move_on(int action, const typename M::Key& key, const typename M::State& next,
               const typename M::Posterior& after) {
    typename M::History remembered;
    M::advance_history(params_, fixed_, state_, action, key, next, history_, remembered);
    history_ = remembered;
    ++step_;
    state_ = next;
    posterior_ = after;
    filter_.accept();
  }

  // Puts the first `count` numbers into order_ in a random order.
  void shuffle(PhiloxDraws& draws, std::size_t count) const {
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint64_t word = draws.word(kSampleSite, i + 1);
      const auto j = static_cast<std::uint32_t>((word * (i + 1)) >> 32);
      order_[i] = order_[j];
      order_[j] = i;
    }
  }

  // Whether the action ends the episode in each of kTrials joint states.
  bool ends_surely(int action) {
    sample(key_, step_, kTrials, trials_);
    trials_.copy_to(trial_fixed_.data(), trial_states_.data());
    for (std::uint32_t i = 0; i < kTrials; ++i) {
      PhiloxDraws draws(key_, i, step_ + 1);
      typename M::State next;
      if (!M::step(params_, trial_fixed_[i], trial_states_[i], action, draws, next).terminal) return false;
    }
    return true;
  }

  const typename M::Params& params_;
  std::uint64_t seed_;
  std::size_t size_;
  StreamKey key_{};
  std::uint32_t step_ = 0;
  typename M::Fixed fixed_{};  // with `state_`: the visible variables; hidden ones are 0
  typename M::State state_{};
  typename M::History history_{};
  typename M::Posterior posterior_{};
  typename FilterOf<M, M::kParticleUnits == 0>::Type filter_;
  mutable std::vector<std::uint32_t> order_;  // with `picks_`: scratch of `sample`, sized by `reserve`
  mutable std::vector<int> picks_;
  ScenarioBuffer trials_;  // with the next two: scratch of `ends_surely`
  std::vector<typename M::Fixed> trial_fixed_;
  std::vector<typename M::State> trial_states_;
};

}  // namespace hypgen
