// SPDX-License-Identifier: Apache-2.0
// Random walks through a model, each folded into one number: how billions of steps are compared between the
// host and a device, or between ways of running a step.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "hypgen/core/config.hpp"
#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/model/key.hpp"
#include "hypgen/model/model.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

// What digests are taken of: lanes first_lane .. first_lane + lanes - 1, each `steps` steps, drawn from stream
// `key`.
struct DigestRange {
  StreamKey key{};
  std::uint32_t first_lane = 0;
  std::uint32_t lanes = 0;
  std::uint32_t steps = 0;
};

// A 64-bit hash of what was added to it, in order.
class Digest {
 public:
  HYPGEN_FN void add(std::uint64_t value) {
    value_ = (value_ ^ value) * 0x9E3779B97F4A7C15U;
    value_ ^= value_ >> 32;
  }
  HYPGEN_FN void add_float(float value) { add(math::canonical_bits(value)); }
  HYPGEN_FN void add_double(double value) { add(math::canonical_bits(value)); }

  // The words of a packed struct, whichever of them are floats. Processors choose the bits of a NaN freely,
  // so every word that would be one counts as the same: of an integer, that hides one value in 256.
  template <class Words>
  HYPGEN_FN void add_words(const Words& words) {
    if constexpr (!std::is_empty_v<Words>) {
      static_assert(sizeof(Words) % sizeof(std::uint32_t) == 0);
      constexpr std::size_t kCount = sizeof(Words) / sizeof(std::uint32_t);
      std::uint32_t copy[kCount];
      std::memcpy(copy, &words, sizeof copy);
      for (std::size_t i = 0; i < kCount; ++i) add_float(math::from_bits(copy[i]));
    }
  }

  template <class Key>
  HYPGEN_FN void add_key(const Key& key) {
    std::uint64_t words[kKeyWords<Key>];
    std::memcpy(words, &key, sizeof words);
    for (std::size_t i = 0; i < kKeyWords<Key>; ++i) add(words[i]);
  }

  HYPGEN_FN std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0;
};

// One random walk: draws legal actions as a trace does, starts again where an episode ends, and folds all
// that a step computes. Nothing is allocated, so that a thread of a GPU can have a lane.
//
// A step is `begin`, then M::step or something equal to it from `state()` by `action()`, then `end`. Where
// `active()` is false no action is legal: the step's result does not count, but taking it does no harm, so
// that threads that share steps can all take one.
template <class M>
class DigestLane {
 public:
  HYPGEN_FN DigestLane(const typename M::Params& params, StreamKey key, std::uint32_t lane)
      : params_(params), key_(key), lane_(lane), draws_(key, lane, 0) {}

  HYPGEN_FN void start() { restart(0); }

  // Prepares step `t` = 0, 1, ..: folds what comes before it and chooses the action.
  HYPGEN_FN void begin(std::uint32_t t) {
    step_ = t;
    draws_ = PhiloxDraws(key_, lane_, t);
    digest_.add_words(state_);
    digest_.add_words(posterior_);
    digest_.add_words(history_);
    digest_.add(code(M::default_policy(params_, fixed_, state_, history_, draws_)));
    action_ = choose_action();
    digest_.add(code(action_));
  }

  HYPGEN_FN bool active() const { return action_ >= 0; }
  HYPGEN_FN int action() const { return active() ? action_ : 0; }
  HYPGEN_FN const typename M::Fixed& fixed() const { return fixed_; }
  HYPGEN_FN const typename M::State& state() const { return state_; }
  HYPGEN_FN PhiloxDraws& draws() { return draws_; }

  // Folds what the step came to, and moves on to `next`.
  HYPGEN_FN void end(const StepResult& result, const typename M::State& next) {
    if (!active()) return restart(step_ + 1);
    digest_.add(static_cast<std::uint64_t>(result.reward));
    digest_.add(std::uint64_t{result.terminal} | std::uint64_t{result.success} << 1 |
                std::uint64_t{result.error} << 2);
    digest_.add_float(M::upper(params_, fixed_, state_));
    digest_.add_float(M::tail(params_, fixed_, state_));
    if constexpr (M::kHasLower) digest_.add_float(M::lower(params_, fixed_, state_, history_));
    digest_.add_words(next);
    if (result.terminal) return restart(step_ + 1);
    const typename M::Key key = M::observe(params_, fixed_, state_, action_, draws_, next);
    digest_.add_key(key);
    digest_.add_double(M::observation_density(params_, fixed_, state_, action_, key, draws_, next));
    condition(key);
    advance(key, next);
    state_ = next;
  }

  HYPGEN_FN void step(std::uint32_t t) {
    begin(t);
    if (!active()) return restart(t + 1);
    typename M::State next{};
    const StepResult result = M::step(params_, fixed_, state_, action_, draws_, next);
    end(result, next);
  }

  HYPGEN_FN std::uint64_t value() const { return digest_.value(); }

 private:
  static constexpr std::uint32_t kActionSite = 0xAC7;      // as in a trace
  static constexpr std::uint32_t kFilterKey = 0x66696C74;  // the filter must not draw what the step drew

  HYPGEN_FN static std::uint64_t code(int action) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(action));
  }

  HYPGEN_FN void restart(std::uint32_t t) {
    PhiloxDraws draws(key_, lane_, t);
    M::init_visible(params_, draws, fixed_, state_);
    M::init_hidden(params_, draws, fixed_, state_);
    M::init_history(params_, fixed_, state_, history_);
    M::init_posterior(params_, fixed_, state_, posterior_);
    digest_.add_words(fixed_);
    if constexpr (SeesFirst<M>::value) digest_.add_double(M::init_likelihood(params_, fixed_, state_));
  }

  // One of the legal actions, each as likely; -1 if there is none.
  HYPGEN_FN int choose_action() {
    std::uint64_t count = 0;
    for (int action = 0; action < M::kActionCount; ++action) {
      count += M::is_legal(params_, fixed_, state_, action) ? 1 : 0;
    }
    const std::uint64_t chosen = (draws_.word(kActionSite, 0) * count) >> 32;
    std::uint64_t passed = 0;
    for (int action = 0; action < M::kActionCount; ++action) {
      if (!M::is_legal(params_, fixed_, state_, action)) continue;
      if (passed == chosen) return action;
      ++passed;
    }
    return -1;
  }

  HYPGEN_FN void condition(const typename M::Key& key) {
    PhiloxDraws draws({key_.key0 ^ kFilterKey, key_.key1}, lane_, step_);
    typename M::State next{};
    digest_.add_double(M::filter(params_, fixed_, state_, action_, key, draws, next));
    digest_.add_words(next);
  }

  // Takes what was seen into the history and the posterior; a rollout's history counts too.
  HYPGEN_FN void advance(const typename M::Key& key, const typename M::State& next) {
    if constexpr (M::kHasHistory) {
      typename M::History rolled;
      M::roll_history(params_, fixed_, state_, action_, draws_, next, history_, rolled);
      digest_.add_words(rolled);
      typename M::History after;
      M::advance_history(params_, fixed_, state_, action_, key, next, history_, after);
      history_ = after;
    }
    if constexpr (M::kExactUnits > 0) {
      const typename M::Posterior before = posterior_;
      digest_.add(M::advance_posterior(params_, fixed_, state_, action_, key, next, before, posterior_) ? 1
                                                                                                        : 0);
    }
  }

  const typename M::Params& params_;
  StreamKey key_;
  std::uint32_t lane_;
  std::uint32_t step_ = 0;
  int action_ = -1;
  PhiloxDraws draws_;
  typename M::Fixed fixed_;
  typename M::State state_;
  typename M::History history_;
  typename M::Posterior posterior_;
  Digest digest_;
};

// The digest of lane `number`, its steps taken by `stepper(params, fixed, state, action, draws, next,
// active)`, which gives a StepResult and writes `next`. The stepper is called exactly `steps` times whatever
// the lane does, so that it may contain barriers between the warps of a block: they all walk the same 32
// lanes, in the same calls. Where `active` is false its result does not count.
template <class M, class Stepper>
HYPGEN_FN std::uint64_t digest_lane(const typename M::Params& params, StreamKey key, std::uint32_t number,
                                    std::uint32_t steps, Stepper&& stepper) {
  DigestLane<M> lane(params, key, number);
  lane.start();
  for (std::uint32_t t = 0; t < steps; ++t) {
    lane.begin(t);
    typename M::State next = lane.state();
    const StepResult result =
        stepper(params, lane.fixed(), lane.state(), lane.action(), lane.draws(), next, lane.active());
    lane.end(result, next);
  }
  return lane.value();
}

}  // namespace hypgen
