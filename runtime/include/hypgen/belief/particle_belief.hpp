// SPDX-License-Identifier: Apache-2.0
// A particle filter. It weighs particles by the likelihood that the model declares for an observation.
#pragma once

#include <cstdint>
#include <cstring>
#include <memory>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/belief/first_draws.hpp"
#include "hypgen/belief/redraw.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen {

// The number of particles stays the same. The filter resamples systematically when the effective sample size
// falls below half of it. A copied particle draws fixed values again that it has not read yet (redraw.hpp).
template <class M>
class ParticleBelief final : public Belief {
 public:
  ParticleBelief(const typename M::Params& params, std::uint64_t seed, std::size_t particles)
      : params_(params), seed_(seed), now_(particles), next_(particles) {
    if constexpr (kTracks) tracked_params_ = copied<typename T::Params>(params);
  }

  Status init(const std::int32_t* visible, std::uint64_t run) override {
    key_ = derive(seed_, StreamKind::kBelief, run);
    step_ = 0;
    visible_.assign(visible, visible + M::kVisibleCount);
    now_.resize(next_.size());
    Status status = Status::kOk;
    if constexpr (SeesFirst<M>::value) {
      status = draw_first();
    } else {
      for (std::uint32_t i = 0; i < now_.size(); ++i) {
        now_[i].origin = i;
        draw_initial(now_[i]);
        now_[i].weight = 1.0 / static_cast<double>(now_.size());
      }
    }
    hypotheses_ = count_distinct();
    T::init_history(params(), now_[0].fixed, now_[0].state, history_);
    return status;
  }

  Status update(int action, KeyWords words) override {
    const auto key = key_from<typename M::Key>(words);
    double total = filter(action, key, 0);
    // Particles that contradict the observation may explain it with other draws.
    for (std::uint32_t round = 1; round <= kRedraws && !(total > 0.0); ++round)
      total = filter(action, key, round);
    if (!(total > 0.0)) return explain_failure(action);
    move_on(action, key, total);
    return Status::kOk;
  }

  // Drops the particles whose episode ends, unless all end.
  void propagate(int action, KeyWords words) override {
    const auto key = key_from<typename M::Key>(words);
    filter(action, key, 0);
    double total = 0.0;
    for (std::uint32_t i = 0; i < now_.size(); ++i) {
      next_[i].weight = ends(i, action) ? 0.0 : now_[i].weight;
      total += next_[i].weight;
    }
    if (!(total > 0.0)) {
      for (std::size_t i = 0; i < now_.size(); ++i) next_[i].weight = now_[i].weight;
      total = 1.0;
    }
    move_on(action, key, total);
  }

  void reserve(ScenarioBuffer& buffer, std::size_t capacity) const override {
    buffer.reserve(sizeof(typename M::Fixed), sizeof(typename M::State), sizeof(typename M::History),
                   capacity);
  }

  void sample(StreamKey key, std::uint32_t first, std::size_t count, ScenarioBuffer& out) const override {
    out.clear(first);
    out.set_history(history_);
    PhiloxDraws draws(key, first, 0);
    choose(draws.word(kSampleSite, 0), count,
           [&](const Particle& particle) { out.push(plain(particle.fixed), particle.state); });
  }

  int default_action(StreamKey key) const override {
    PhiloxDraws draws(key, 0, 0);
    return T::default_policy(params(), now_[0].fixed, now_[0].state, history_, draws);
  }

  void each_value(int variable, const TakeValue& take) const override {
    std::int32_t values[M::kVariableCount];
    for (const Particle& particle : now_) {
      const typename T::Fixed fixed = particle.fixed;  // a copy, so that the particle notes no read
      T::export_state(fixed, particle.state, values);
      take(values[variable], particle.weight);
    }
  }

  void export_particles(ScenarioBuffer& particles, std::vector<double>& weights) const override {
    particles.clear(0);
    particles.set_history(history_);
    weights.clear();
    for (const Particle& particle : now_) {
      particles.push(plain(particle.fixed), particle.state);
      weights.push_back(particle.weight);
    }
  }

  bool import_particles(const ScenarioBuffer& particles, const std::vector<double>& weights) override {
    if (particles.size() != now_.size() || weights.size() != now_.size() ||
        !particles.holds(sizeof(typename M::Fixed), sizeof(typename M::State), sizeof history_)) {
      return false;
    }
    std::vector<typename M::Fixed> fixed(now_.size());
    std::vector<typename T::State> states(now_.size());
    particles.copy_to(fixed.data(), states.data());
    particles.copy_history_to(history_);
    for (std::uint32_t i = 0; i < now_.size(); ++i) {
      now_[i].fixed = all_read(fixed[i]);
      now_[i].state = states[i];
      now_[i].weight = weights[i];
      now_[i].origin = i;
    }
    hypotheses_ = count_distinct();
    return true;
  }

  double effective_sample_size() const override {
    double sum = 0.0;
    for (const Particle& particle : now_) sum += particle.weight * particle.weight;
    return 1.0 / sum;
  }

  std::size_t size() const override { return now_.size(); }

 private:
  static constexpr std::uint32_t kRedraws = 16;
  static constexpr bool kTracks = Tracked<M>::kAny;
  using T = typename Tracked<M>::Model;  // as M, but for the type of the words of Fixed

  // The sites of a particle's own words: the first ones, and those of the two proposals.
  static constexpr std::uint32_t kFirstSite = site_id("belief:first");
  static constexpr std::uint32_t kAllSite = site_id("belief:all");
  static constexpr std::uint32_t kEntriesSite = site_id("belief:entries");

  struct Particle : Tracked<M>::Own {
    typename T::Fixed fixed;
    typename T::State state;
    double weight;
    std::uint32_t origin;  // the particle whose draws its initial values come from, redrawn values apart
  };

  // Copies the bytes of a type of M to the same type of T.
  template <class To, class From>
  static std::unique_ptr<To> copied(const From& from) {
    static_assert(sizeof(To) == sizeof(From) && std::is_trivially_copyable_v<To>);
    auto to = std::make_unique<To>();
    std::memcpy(to.get(), &from, sizeof from);
    return to;
  }

  const typename T::Params& params() const {
    if constexpr (kTracks) {
      return *tracked_params_;
    } else {
      return params_;
    }
  }

  static typename M::Fixed plain(const typename T::Fixed& fixed) {
    if constexpr (kTracks) {
      typename M::Fixed words;
      for (std::size_t i = 0; i < kFixedWords; ++i) words.words[i] = fixed.words[i].value;
      return words;
    } else {
      return fixed;
    }
  }

  static typename T::Fixed all_read(const typename M::Fixed& fixed) {
    if constexpr (kTracks) {
      typename T::Fixed words;
      for (std::size_t i = 0; i < kFixedWords; ++i) words.words[i] = {fixed.words[i], ~std::uint32_t{0}};
      return words;
    } else {
      return fixed;
    }
  }

  // Draws a particle's initial values, and forgets the reads that drawing them took.
  void draw_initial(Particle& particle) const {
    T::import_visible(visible_.data(), particle.fixed, particle.state);
    PhiloxDraws draws(key_, particle.origin, 0);
    if constexpr (kTracks) {
      for (std::uint32_t w = 0; w < M::kRedrawnWords; ++w) particle.words[w] = draws.word(kFirstSite, w);
      OwnDraws<M> own(draws, particle.words);
      T::init_hidden(params(), own, particle.fixed, particle.state);
      for (TrackedWord& word : particle.fixed.words) word.read = 0;
      particle.start = particle.state;
    } else {
      T::init_hidden(params(), draws, particle.fixed, particle.state);
    }
  }

  // Draws the particles given what is seen at the start.
  Status draw_first() {
    FirstDraws first(now_.size(), 1);
    const auto drawn = [&](Particle& particle, std::uint32_t candidate) {
      particle.origin = candidate;
      draw_initial(particle);
      return T::init_likelihood(params(), particle.fixed, particle.state);
    };
    do {
      for (std::size_t i = 0; i < now_.size(); ++i) {
        const double likelihood = drawn(next_[i], first.count());
        first.add(&likelihood);
      }
    } while (first.wants_more());
    PhiloxDraws draws(key_, 0, 0);
    const auto take = [&](std::uint32_t i, std::uint32_t candidate, double weight) {
      drawn(now_[i], candidate);
      redraw_unread(now_[i], PhiloxDraws(key_, i, 0));  // several particles may be the same candidate
      now_[i].weight = weight;
    };
    return first.choose(0, draws.word(kResampleSite, 0), take) ? Status::kOk : Status::kImpossibleObservation;
  }

  // Draws again what a particle has not read. It proposes all unread words first, then those of arrays alone:
  // the second proposal is more likely to leave the read values as they are.
  void redraw_unread(Particle& particle, const PhiloxDraws& fresh) const {
    if constexpr (kTracks) {
      if (M::kRedrawnSingles > 0) propose(particle, fresh, kAllSite, 0);
      propose(particle, fresh, kEntriesSite, M::kRedrawnSingles);
    }
  }

  // Draws the unread words from `first` on again. Keeps them only if all read values and the initial values
  // of State stay the same.
  void propose(Particle& particle, const PhiloxDraws& fresh, std::uint32_t purpose, int first) const {
    if constexpr (kTracks) {
      int unread = first;  // the first such word: where all are read, the initial law need not run again
      while (unread < M::kRedrawnWords && T::is_word_read(particle.fixed, unread)) ++unread;
      if (unread == M::kRedrawnWords) return;
      Particle other = particle;
      PhiloxDraws words = fresh;
      for (int w = unread; w < M::kRedrawnWords; ++w) {
        if (!T::is_word_read(particle.fixed, w))
          other.words[w] = words.word(purpose, static_cast<std::uint32_t>(w));
      }
      typename T::State state;
      T::import_visible(visible_.data(), other.fixed, state);
      OwnDraws<M> draws(PhiloxDraws(key_, particle.origin, 0), other.words);
      T::init_hidden(params(), draws, other.fixed, state);
      if (std::memcmp(&state, &particle.start, sizeof state) != 0) return;
      for (std::size_t i = 0; i < kFixedWords; ++i) {
        TrackedWord& word = other.fixed.words[i];
        word.read = particle.fixed.words[i].read;
        if (((word.value ^ particle.fixed.words[i].value) & word.read) != 0) return;
      }
      particle = other;
    }
  }

  PhiloxDraws draws_of(std::uint32_t particle, std::uint32_t round) const {
    return PhiloxDraws(key_, particle + round * static_cast<std::uint32_t>(now_.size()), step_ + 1);
  }

  // Moves all particles to next_ and weighs them; gives the sum of the weights, which are not normalised.
  double filter(int action, const typename M::Key& key, std::uint32_t round) {
    double total = 0.0;
    for (std::uint32_t i = 0; i < now_.size(); ++i) {
      const Particle& from = now_[i];
      PhiloxDraws draws = draws_of(i, round);
      next_[i] = from;
      if (round > 0) redraw_unread(next_[i], draws);
      const double density =
          T::filter(params(), next_[i].fixed, from.state, action, key, draws, next_[i].state);
      next_[i].weight = from.weight * density;
      total += next_[i].weight;
    }
    return total;
  }

  // Makes next_ the belief. Its weights add up to `total`.
  void move_on(int action, const typename M::Key& key, double total) {
    ++step_;
    for (Particle& particle : next_) particle.weight /= total;
    // The history depends on visible variables alone, which are the same in all particles.
    typename T::History after;
    T::advance_history(params(), now_[0].fixed, now_[0].state, action, key, next_[0].state, history_, after);
    history_ = after;
    now_.swap(next_);
    if (effective_sample_size() < 0.5 * static_cast<double>(now_.size())) resample();
  }

  // Calls `take` with `count` particles by systematic resampling: one random word places all pointers.
  template <class Take>
  void choose(std::uint32_t word, std::size_t count, const Take& take) const {
    const double stride = 1.0 / static_cast<double>(count);
    const double offset = static_cast<double>(word) * 0x1p-32;
    double reached = now_[0].weight;
    std::size_t particle = 0;
    std::size_t end = now_.size();  // of the particles with weight: the sum of weights may round to below 1
    while (end > 1 && !(now_[end - 1].weight > 0.0)) --end;
    for (std::size_t i = 0; i < count; ++i) {
      const double pointer = (static_cast<double>(i) + offset) * stride;
      while (reached <= pointer && particle + 1 < end) reached += now_[++particle].weight;
      take(now_[particle]);
    }
  }

  void resample() {
    PhiloxDraws draws(key_, 0, step_);
    std::size_t i = 0;
    choose(draws.word(kResampleSite, 0), now_.size(),
           [&](const Particle& particle) { next_[i++] = particle; });
    now_.swap(next_);
    for (i = 0; i < now_.size(); ++i) {
      now_[i].weight = 1.0 / static_cast<double>(now_.size());
      redraw_unread(now_[i], PhiloxDraws(key_, static_cast<std::uint32_t>(i), step_));
    }
  }

  // The reason why no particle explains the observation.
  Status explain_failure(int action) const {
    bool all_terminal = true;
    for (std::uint32_t i = 0; i < now_.size() && all_terminal; ++i) all_terminal = ends(i, action);
    if (all_terminal) return Status::kAllParticlesTerminal;
    return count_distinct() < hypotheses_ ? Status::kDepletedBelief : Status::kImpossibleObservation;
  }

  // Whether the action ends a particle's episode, with the draws of round 0.
  bool ends(std::uint32_t particle, int action) const {
    PhiloxDraws draws = draws_of(particle, 0);
    typename T::State next;
    return T::step(params(), now_[particle].fixed, now_[particle].state, action, draws, next).terminal;
  }

  // The number of hypotheses. Copies of a particle that differ in redrawn values count as one.
  std::size_t count_distinct() const {
    std::set<std::string> distinct;
    for (const Particle& particle : now_) {
      if (!(particle.weight > 0.0)) continue;
      std::string bytes;
      if constexpr (kTracks) {
        bytes = std::to_string(particle.origin);
      } else {
        bytes.resize(sizeof particle.fixed + sizeof particle.state);
        std::memcpy(bytes.data(), &particle.fixed, sizeof particle.fixed);
        std::memcpy(bytes.data() + sizeof particle.fixed, &particle.state, sizeof particle.state);
      }
      distinct.insert(std::move(bytes));
    }
    return distinct.size();
  }

  static constexpr std::size_t kFixedWords = sizeof(typename M::Fixed) / sizeof(std::uint32_t);

  const typename M::Params& params_;
  std::unique_ptr<typename T::Params> tracked_params_;  // if kTracks
  std::uint64_t seed_;
  StreamKey key_{};
  std::uint32_t step_ = 0;
  std::size_t hypotheses_ = 0;         // at the start of the episode
  std::vector<std::int32_t> visible_;  // their initial values
  typename T::History history_{};
  std::vector<Particle> now_;
  std::vector<Particle> next_;
};

}  // namespace hypgen
