// SPDX-License-Identifier: Apache-2.0
// The world that the agent acts in.
#pragma once

#include <cstdint>
#include <utility>

#include "hypgen/core/config.hpp"
#include "hypgen/model/key.hpp"
#include "hypgen/model/model.hpp"
#include "hypgen/model/start_values.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

// What a step of the world gives back; `reward` is the result's as a number, and `key` is the observation, valid until the next step, and
// zeroes after a terminal one.
struct WorldStep {
  StepResult result;
  double reward;
  KeyWords key;
};

class World {
 public:
  virtual ~World() = default;

  // Starts episode `run`. Episodes of the same number draw the same words whatever the agent does.
  virtual void reset(std::uint64_t run) = 0;
  // Later episodes start with these values, and draw the others.
  virtual void set_start(StartValues start) = 0;
  virtual void export_visible(std::int32_t* out) const = 0;
  virtual void export_state(std::int32_t* out) const = 0;  // of which the agent knows a part
  virtual bool is_legal(int action) const = 0;
  virtual WorldStep step(int action) = 0;
};

// An episode that a model simulates. A world alone and many beside each other play by it, and so alike.
template <class M>
struct SimulatedEpisode {
  std::uint32_t number = 0;
  std::uint32_t time = 0;
  typename M::Fixed fixed{};
  typename M::State state{};

  HYPGEN_FN void begin(const typename M::Params& params, StreamKey key, std::uint64_t run, StartView start) {
    number = static_cast<std::uint32_t>(run);
    time = 0;
    StartDraws draws(key, number, start);
    M::init_visible(params, draws, fixed, state);
    M::init_hidden(params, draws, fixed, state);
  }

  HYPGEN_LARGE_FN StepResult step(const typename M::Params& params, StreamKey key, int action,
                                  typename M::Key& seen) {
    PhiloxDraws draws(key, number, time++);
    typename M::State next;
    const StepResult result = M::step(params, fixed, state, action, draws, next);
    seen = result.terminal ? typename M::Key{} : M::observe(params, fixed, state, action, draws, next);
    state = next;
    return result;
  }
};

// A world that a model simulates.
template <class M>
class ModelWorld final : public World {
 public:
  ModelWorld(const typename M::Params& params, std::uint64_t seed)
      : params_(params), key_(derive(seed, StreamKind::kWorld, 0)) {}

  void reset(std::uint64_t run) override { now_.begin(params_, key_, run, start_.view()); }

  void set_start(StartValues start) override { start_ = std::move(start); }

  void export_visible(std::int32_t* out) const override { M::export_visible(now_.fixed, now_.state, out); }

  void export_state(std::int32_t* out) const override { M::export_state(now_.fixed, now_.state, out); }

  bool is_legal(int action) const override { return M::is_legal(params_, now_.fixed, now_.state, action); }

  WorldStep step(int action) override {
    const StepResult result = now_.step(params_, key_, action, seen_);
    return {result, from_fixed_sum<kRewardBits<M>>(result.reward), words_of(seen_)};
  }

 private:
  const typename M::Params& params_;
  StreamKey key_;
  StartValues start_;
  SimulatedEpisode<M> now_;
  typename M::Key seen_{};
};

}  // namespace hypgen
