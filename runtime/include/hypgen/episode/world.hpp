// SPDX-License-Identifier: Apache-2.0
// The world that the agent acts in.
#pragma once

#include <cstdint>

#include "hypgen/model/key.hpp"
#include "hypgen/model/model.hpp"
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
  virtual void export_visible(std::int32_t* out) const = 0;
  virtual void export_state(std::int32_t* out) const = 0;  // of which the agent knows a part
  virtual bool is_legal(int action) const = 0;
  virtual WorldStep step(int action) = 0;
};

// A world that a model simulates.
template <class M>
class ModelWorld final : public World {
 public:
  ModelWorld(const typename M::Params& params, std::uint64_t seed)
      : params_(params), key_(derive(seed, StreamKind::kWorld, 0)) {}

  void reset(std::uint64_t run) override {
    run_ = static_cast<std::uint32_t>(run);
    time_ = 0;
    PhiloxDraws draws(key_, run_, 0);
    M::init_visible(params_, draws, fixed_, state_);
    M::init_hidden(params_, draws, fixed_, state_);
  }

  void export_visible(std::int32_t* out) const override { M::export_visible(fixed_, state_, out); }

  void export_state(std::int32_t* out) const override { M::export_state(fixed_, state_, out); }

  bool is_legal(int action) const override { return M::is_legal(params_, fixed_, state_, action); }

  WorldStep step(int action) override {
    PhiloxDraws draws(key_, run_, time_++);
    typename M::State next;
    const StepResult result = M::step(params_, fixed_, state_, action, draws, next);
    seen_ = result.terminal ? typename M::Key{} : M::observe(params_, fixed_, state_, action, draws, next);
    state_ = next;
    return {result, from_fixed_sum<kRewardBits<M>>(result.reward), words_of(seen_)};
  }

 private:
  const typename M::Params& params_;
  StreamKey key_;
  std::uint32_t run_ = 0;
  std::uint32_t time_ = 0;
  typename M::Fixed fixed_{};
  typename M::State state_{};
  typename M::Key seen_{};
};

}  // namespace hypgen
