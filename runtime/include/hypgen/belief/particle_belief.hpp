// SPDX-License-Identifier: Apache-2.0
// A belief of particles that are whole states, for models whose hidden variables are not independent.
#pragma once

#include <cstdint>
#include <cstring>
#include <memory>
#include <type_traits>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/belief/particle_filter.hpp"
#include "hypgen/belief/systematic.hpp"
#include "hypgen/belief/whole_state.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen {

// The number of particles stays the same.
template <class M>
class ParticleBelief final : public Belief {
 public:
  ParticleBelief(const typename M::Params& params, std::uint64_t seed, std::size_t particles)
      : params_(params),
        tracked_params_(copied(params)),
        seed_(seed),
        size_(particles),
        hypotheses_found_(particles),
        filter_(this->params(), particles) {}

  void use(Workers* workers) override { filter_.use(workers); }

  Status init(const std::int32_t* visible, std::uint64_t run) override {
    key_ = derive(seed_, StreamKind::kBelief, run);
    step_ = 0;
    T::import_visible(visible, fixed_.values, state_);
    const bool is_possible = filter_.init(key_, fixed_, state_);
    hypotheses_ = count_hypotheses();
    T::init_history(params(), fixed_.values, state_, history_);
    return is_possible ? Status::kOk : Status::kImpossibleObservation;
  }

  Status update(int action, KeyWords words) override {
    const auto key = key_from<typename M::Key>(words);
    if (!filter_.weigh(state_, action, key, kRedraws)) return explain_failure(action);
    move_on(action, key);
    return Status::kOk;
  }

  // Drops the particles whose episode ends, unless all end. To start again from the initial law would forget
  // all that is known of what the observation does not tell of.
  void propagate(int action, KeyWords words) override {
    const auto key = key_from<typename M::Key>(words);
    if (!filter_.weigh(state_, action, key, 0))
      filter_.drop(0, [&](std::uint32_t i) { return ends(i, action); });
    move_on(action, key);
  }

  void reserve(ScenarioBuffer& buffer, std::size_t capacity) const override {
    buffer.reserve(sizeof(typename M::Fixed), sizeof(typename M::State), sizeof(typename M::History),
                   capacity);
  }

  void sample(StreamKey key, std::uint32_t first, std::size_t count, ScenarioBuffer& out) const override {
    out.clear(first);
    out.set_history(history_);
    PhiloxDraws draws(key, first, 0);
    choose([&](int i) { return filter_.weight(0, i); }, filter_.count(0), draws.word(kSampleSite, 0), count,
           [&](std::size_t, int i) { out.push(U::plain(filter_.fixed(i)), filter_.state(i)); });
  }

  bool is_legal(int action) const override { return T::is_legal(params(), fixed_.values, state_, action); }

  int default_action(StreamKey key) const override {
    PhiloxDraws draws(key, 0, 0);
    return T::default_policy(params(), fixed_.values, state_, history_, draws);
  }

  void each_value(int variable, const TakeValue& take) const override {
    std::int32_t values[M::kVariableCount];
    for (int i = 0; i < filter_.count(0); ++i) {
      U::export_state(filter_.fixed(i), filter_.state(i), values);
      take(values[variable], filter_.weight(0, i));
    }
  }

  void export_particles(ScenarioBuffer& particles, std::vector<double>& weights) const override {
    particles.clear(0);
    particles.set_history(history_);
    weights.clear();
    for (int i = 0; i < filter_.count(0); ++i) {
      particles.push(U::plain(filter_.fixed(i)), filter_.state(i));
      weights.push_back(filter_.weight(0, i));
    }
  }

  bool import_particles(const ScenarioBuffer& particles, const std::vector<double>& weights) override {
    if (particles.size() != size_ || weights.size() != size_ ||
        !particles.holds(sizeof(typename M::Fixed), sizeof(typename M::State), sizeof history_)) {
      return false;
    }
    std::vector<typename M::Fixed> plain(size_);
    std::vector<typename T::State> states(size_);
    particles.copy_to(plain.data(), states.data());
    particles.copy_history_to(history_);
    std::vector<typename U::Fixed> fixed(size_);
    for (std::size_t i = 0; i < size_; ++i) fixed[i] = U::all_read(plain[i]);
    filter_.import(fixed, states, weights);
    see();
    hypotheses_ = count_hypotheses();
    return true;
  }

  std::vector<UnitHealth> health() const override { return filter_.health(); }

  double effective_sample_size() const override { return filter_.effective_size(0); }

  std::size_t size() const override { return size_; }

 private:
  static constexpr std::uint32_t kRedraws = 16;  // of particles that all contradict an observation
  using U = WholeState<M>;
  using T = typename U::T;

  static std::unique_ptr<typename T::Params> copied(const typename M::Params& params) {
    if constexpr (std::is_same_v<T, M>) {
      return nullptr;
    } else {
      using To = typename T::Params;
      static_assert(sizeof(To) == sizeof params && std::is_trivially_copyable_v<To>);
      auto to = std::make_unique<To>();
      std::memcpy(to.get(), &params, sizeof params);
      return to;
    }
  }

  const typename T::Params& params() const {
    if constexpr (std::is_same_v<T, M>) {
      return params_;
    } else {
      return *tracked_params_;
    }
  }

  // Makes the moved particles the belief.
  void move_on(int action, const typename M::Key& key) {
    filter_.accept();
    ++step_;
    const typename T::State before = state_;
    see();
    typename T::History after;
    T::advance_history(params(), fixed_.values, before, action, key, state_, history_, after);
    history_ = after;
  }

  // Takes the visible variables, which are the same in all particles.
  void see() {
    std::int32_t visible[M::kVisibleCount + 1];
    const typename T::Fixed fixed = filter_.fixed(0).values;  // a copy, so that the particle notes no read
    T::export_visible(fixed, filter_.state(0), visible);
    T::import_visible(visible, fixed_.values, state_);
  }

  // The reason why no particle explains the observation.
  Status explain_failure(int action) {
    bool all_terminal = true;
    for (std::uint32_t i = 0; i < size_ && all_terminal; ++i) all_terminal = ends(i, action);
    if (all_terminal) return Status::kAllParticlesTerminal;
    const bool lost = filter_.has_lost_starts() || count_hypotheses() < hypotheses_;
    return lost ? Status::kDepletedBelief : Status::kImpossibleObservation;
  }

  // Whether the action ends a particle's episode.
  bool ends(std::uint32_t particle, int action) const {
    const auto i = static_cast<int>(particle);
    PhiloxDraws draws(key_, particle, step_ + 1);
    const typename T::Fixed fixed = filter_.fixed(i).values;
    typename T::State next;
    return T::step(params(), fixed, filter_.state(i), action, draws, next).terminal;
  }

  // Copies of a particle that differ in redrawn values count as one.
  std::size_t count_hypotheses() {
    hypotheses_found_.clear(size_);
    for (int i = 0; i < filter_.count(0); ++i) {
      if (!(filter_.weight(0, i) > 0.0)) continue;
      if constexpr (U::kRedraws) {
        hypotheses_found_.add(ValueSet::mixed(filter_.origin(0, i)));
      } else {
        const std::uint64_t fixed = ValueSet::hash_of(filter_.fixed(i).values, 0);
        hypotheses_found_.add(ValueSet::hash_of(filter_.state(i), fixed));
      }
    }
    return hypotheses_found_.size();
  }

  const typename M::Params& params_;
  std::unique_ptr<typename T::Params> tracked_params_;  // where copies draw again what they have not read
  std::uint64_t seed_;
  std::size_t size_;
  StreamKey key_{};
  std::uint32_t step_ = 0;
  std::size_t hypotheses_ = 0;  // at the start of the episode
  ValueSet hypotheses_found_;   // scratch
  typename U::Fixed fixed_{};   // with `state_`: the visible variables; hidden ones are 0
  typename T::State state_{};
  typename T::History history_{};
  ParticleFilter<U> filter_;
};

}  // namespace hypgen
