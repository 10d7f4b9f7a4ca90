// SPDX-License-Identifier: Apache-2.0
// A belief that is a product of posteriors, one for each unit. A unit is a group of hidden variables that is
// independent of all others: an element of the model, or one member of a family. A unit of few values has an
// exact posterior, any other has particles.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/belief/first_draws.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen {

// M::unit_of numbers the units: exact ones first, then those with particles. The particles of all units share
// an array in which each unit owns a column. A column has weights of its own and is resampled by itself.
template <class M>
class FactoredBelief final : public Belief {
 public:
  FactoredBelief(const typename M::Params& params, std::uint64_t seed, std::size_t particles)
      : params_(params),
        seed_(seed),
        size_(particles),
        now_(M::kParticleUnits > 0 ? particles : 0),
        next_(now_.size()),
        weights_(now_.size() * M::kParticleUnits),
        next_weights_(weights_.size()) {}

  Status init(const std::int32_t* visible, std::uint64_t run) override {
    key_ = derive(seed_, StreamKind::kBelief, run);
    step_ = 0;
    resampled_ = false;
    M::import_visible(visible, fixed_, state_);
    M::init_history(params_, fixed_, state_, history_);
    if constexpr (SeesFirst<M>::value) {
      const bool is_possible = M::init_posterior(params_, fixed_, state_, posterior_);
      return draw_first() && is_possible ? Status::kOk : Status::kImpossibleObservation;
    } else {
      M::init_posterior(params_, fixed_, state_, posterior_);
      for (std::uint32_t i = 0; i < now_.size(); ++i) draw_initial(i, now_[i]);
      std::fill(weights_.begin(), weights_.end(), 1.0 / static_cast<double>(size_));
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
    bool explained = filter(action, key, 0);
    // Particles that contradict the observation may explain it with other draws.
    for (std::uint32_t round = 1; round <= kRedraws && !explained; ++round)
      explained = filter(action, key, round);
    if (!explained) {
      if (ends_surely(action)) return Status::kAllParticlesTerminal;
      return resampled_ ? Status::kDepletedBelief : Status::kImpossibleObservation;
    }
    move_on(action, key, next, after);
    return Status::kOk;
  }

  // A unit keeps its posterior, or its particles' weights, if all its values contradict the observation.
  void propagate(int action, KeyWords words) override {
    const auto key = key_from<typename M::Key>(words);
    typename M::State next;
    typename M::Posterior after;
    M::advance_visible(params_, fixed_, state_, action, key, next);
    M::advance_posterior(params_, fixed_, state_, action, key, next, posterior_, after);
    filter(action, key, 0);
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
      choose(unit, draws.word(kSampleSite, 0), count,
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

  int default_action(StreamKey key) const override {
    PhiloxDraws draws(key, 0, 0);
    return M::default_policy(params_, fixed_, state_, history_, draws);
  }

  double marginal(int variable, std::int32_t value) const override {
    const int unit = M::unit_of(variable);
    if (unit < 0) return holds(variable, value, fixed_, state_) ? 1.0 : 0.0;
    double sum = 0.0;
    for (int i = 0; i < values_of(unit); ++i) {
      typename M::Fixed fixed = fixed_;
      typename M::State state = state_;
      put(unit, i, fixed, state);
      if (holds(variable, value, fixed, state)) sum += weight(unit, i);
    }
    return sum;
  }

  // A sample of `size()` joint states.
  void export_particles(ScenarioBuffer& particles, std::vector<double>& weights) const override {
    reserve(particles, size_);
    sample(derive(seed_, StreamKind::kBelief, UINT64_MAX), 0, size_, particles);
    weights.assign(size_, 1.0 / static_cast<double>(size_));
  }

  bool import_particles(const ScenarioBuffer&, const std::vector<double>&) override { return false; }

  // The least of all units with particles; `size()` where all posteriors are exact.
  double effective_sample_size() const override {
    double least = static_cast<double>(size_);
    for (int unit = 0; unit < M::kParticleUnits; ++unit) least = std::min(least, effective_size(unit));
    return least;
  }

  std::size_t size() const override { return size_; }

 private:
  static constexpr std::uint32_t kRedraws = 16;
  static constexpr int kUnits = M::kExactUnits + M::kParticleUnits;
  static constexpr std::size_t kTrials = 256;  // joint states on which ends_surely tries an action

  struct Particle {
    typename M::Fixed fixed;
    typename M::State state;
  };

  void draw_initial(std::uint32_t number, Particle& particle) const {
    PhiloxDraws draws(key_, number, 0);
    particle = {fixed_, state_};
    M::init_hidden(params_, draws, particle.fixed, particle.state);
  }

  // Draws each unit's particles given what is seen at the start; false if none of some unit explain it.
  bool draw_first() {
    bool all_explained = true;
    if constexpr (M::kParticleUnits > 0) {
      FirstDraws first(size_, M::kParticleUnits);
      Particle candidate{};
      do {
        for (std::size_t i = 0; i < size_; ++i) {
          double likelihoods[M::kParticleUnits];
          draw_initial(first.count(), candidate);
          M::init_weights(params_, candidate.fixed, candidate.state, likelihoods);
          first.add(likelihoods);
        }
      } while (first.wants_more());
      std::fill(now_.begin(), now_.end(), Particle{fixed_, state_});
      for (std::uint32_t unit = 0; unit < M::kParticleUnits; ++unit) {
        PhiloxDraws draws(key_, unit, 0);
        std::uint32_t drawn = first.count();  // the candidate at hand: none yet
        const auto take = [&](std::uint32_t i, std::uint32_t number, double weight) {
          if (number != drawn) draw_initial(drawn = number, candidate);
          M::copy_unit(static_cast<int>(unit), candidate.fixed, candidate.state, now_[i].fixed,
                       now_[i].state);
          weights_[unit * size_ + i] = weight;
        };
        const bool is_explained = first.choose(unit, draws.word(kResampleSite, 0), take);
        all_explained = all_explained && is_explained;
      }
    }
    return all_explained;
  }

  static bool holds(int variable, std::int32_t value, const typename M::Fixed& fixed,
                    const typename M::State& state) {
    if (variable < 0 || variable >= M::kVariableCount) return false;
    std::int32_t values[M::kVariableCount];
    M::export_state(fixed, state, values);
    return values[variable] == value;
  }

  // The number of a unit's joint values or particles.
  int values_of(int unit) const {
    if constexpr (M::kExactUnits > 0) {
      if (unit < M::kExactUnits) return M::unit_size(unit);
    }
    return static_cast<int>(now_.size());
  }

  // The probability of joint value i of a unit, or the weight of its particle i.
  double weight(int unit, int i) const {
    if constexpr (M::kExactUnits > 0) {
      if (unit < M::kExactUnits) return M::probability(posterior_, unit, i);
    }
    return weights_[static_cast<std::size_t>(unit - M::kExactUnits) * now_.size() +
                    static_cast<std::size_t>(i)];
  }

  // Writes joint value i of a unit, or the unit's variables in particle i.
  void put(int unit, int i, typename M::Fixed& fixed, typename M::State& state) const {
    if constexpr (M::kExactUnits > 0) {
      if (unit < M::kExactUnits) M::put_unit(unit, i, fixed, state);
    }
    if constexpr (M::kParticleUnits > 0) {
      if (unit < M::kExactUnits) return;
      const Particle& from = now_[static_cast<std::size_t>(i)];
      M::copy_unit(unit - M::kExactUnits, from.fixed, from.state, fixed, state);
    }
  }

  // Makes the visible state `next`, the posteriors `after` and the particles in next_ the belief.
  void move_on(int action, const typename M::Key& key, const typename M::State& next,
               const typename M::Posterior& after) {
    typename M::History remembered;
    M::advance_history(params_, fixed_, state_, action, key, next, history_, remembered);
    history_ = remembered;
    ++step_;
    state_ = next;
    posterior_ = after;
    now_.swap(next_);
    weights_.swap(next_weights_);
    if constexpr (M::kParticleUnits > 0) {
      for (int unit = 0; unit < M::kParticleUnits; ++unit) {
        if (effective_size(unit) < 0.5 * static_cast<double>(size_)) resample(unit);
      }
    }
  }

  // Moves all particles to next_ and weighs them. Gives false if all particles of some unit contradict the
  // key; that unit keeps its weights.
  bool filter(int action, const typename M::Key& key, std::uint32_t round) {
    bool all_explained = true;
    if constexpr (M::kParticleUnits > 0) {
      double factors[M::kParticleUnits];
      double totals[M::kParticleUnits] = {};
      const std::size_t count = now_.size();
      for (std::uint32_t i = 0; i < count; ++i) {
        PhiloxDraws draws(key_, i + round * static_cast<std::uint32_t>(count), step_ + 1);
        const Particle& from = now_[i];
        next_[i].fixed = from.fixed;
        M::filter_particles(params_, from.fixed, from.state, action, key, draws, next_[i].state, factors);
        for (std::size_t unit = 0; unit < M::kParticleUnits; ++unit) {
          next_weights_[unit * count + i] = weights_[unit * count + i] * factors[unit];
          totals[unit] += next_weights_[unit * count + i];
        }
      }
      for (std::size_t unit = 0; unit < M::kParticleUnits; ++unit) {
        const bool explained = totals[unit] > 0.0;
        all_explained = all_explained && explained;
        for (std::size_t i = unit * count; i < (unit + 1) * count; ++i) {
          next_weights_[i] = explained ? next_weights_[i] / totals[unit] : weights_[i];
        }
      }
    }
    return all_explained;
  }

  double effective_size(int particle_unit) const {
    double sum = 0.0;
    const double* const weights = weights_.data() + static_cast<std::size_t>(particle_unit) * now_.size();
    for (std::size_t i = 0; i < now_.size(); ++i) sum += weights[i] * weights[i];
    return 1.0 / sum;
  }

  // Calls `take(i, pick)` for each i < count: `pick` is a joint value or particle, by systematic sampling.
  template <class Take>
  void choose(int unit, std::uint32_t word, std::size_t count, const Take& take) const {
    const double stride = 1.0 / static_cast<double>(count);
    const double offset = static_cast<double>(word) * 0x1p-32;
    int end = values_of(unit);
    while (end > 1 && !(weight(unit, end - 1) > 0.0)) --end;  // the sum of weights may round to below 1
    int pick = 0;
    double reached = weight(unit, 0);
    for (std::size_t i = 0; i < count; ++i) {
      const double pointer = (static_cast<double>(i) + offset) * stride;
      while (reached <= pointer && pick + 1 < end) reached += weight(unit, ++pick);
      take(i, pick);
    }
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

  void resample(int particle_unit) {
    PhiloxDraws draws(key_, static_cast<std::uint32_t>(particle_unit), step_);
    const int unit = M::kExactUnits + particle_unit;
    choose(unit, draws.word(kResampleSite, 0), now_.size(),
           [&](std::size_t i, int pick) { put(unit, pick, next_[i].fixed, next_[i].state); });
    for (std::size_t i = 0; i < now_.size(); ++i) {
      M::copy_unit(particle_unit, next_[i].fixed, next_[i].state, now_[i].fixed, now_[i].state);
    }
    double* const weights = weights_.data() + static_cast<std::size_t>(particle_unit) * now_.size();
    std::fill_n(weights, now_.size(), 1.0 / static_cast<double>(now_.size()));
    resampled_ = true;
  }

  // Whether the action ends the episode in each of kTrials joint states.
  bool ends_surely(int action) const {
    ScenarioBuffer buffer;
    reserve(buffer, kTrials);
    sample(key_, step_, kTrials, buffer);
    std::vector<typename M::Fixed> fixed(kTrials);
    std::vector<typename M::State> states(kTrials);
    buffer.copy_to(fixed.data(), states.data());
    for (std::uint32_t i = 0; i < kTrials; ++i) {
      PhiloxDraws draws(key_, i, step_ + 1);
      typename M::State next;
      if (!M::step(params_, fixed[i], states[i], action, draws, next).terminal) return false;
    }
    return true;
  }

  const typename M::Params& params_;
  std::uint64_t seed_;
  std::size_t size_;
  StreamKey key_{};
  std::uint32_t step_ = 0;
  bool resampled_ = false;     // in this episode
  typename M::Fixed fixed_{};  // with `state_`: the visible variables; hidden ones are 0
  typename M::State state_{};
  typename M::History history_{};
  typename M::Posterior posterior_{};
  std::vector<Particle> now_;
  std::vector<Particle> next_;
  std::vector<double> weights_;  // unit by unit
  std::vector<double> next_weights_;
  mutable std::vector<std::uint32_t> order_;  // with `picks_`: scratch of `sample`, sized by `reserve`
  mutable std::vector<int> picks_;
};

}  // namespace hypgen
