// SPDX-License-Identifier: Apache-2.0
// Rollouts of the default policy in lanes: each lane plays a rollout to its end and takes the next one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "hypgen/lanes/draws.hpp"
#include "hypgen/lanes/kernel.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen::lanes {

/// The outcome of a step in each lane. The reward is in fixed point, a whole number.
struct StepLanes {
  Double reward;
  Mask terminal;
  Mask success;
  Mask error;
};

/// Words of many scenarios, of which one at a time is set.
template <std::size_t N>
HYPGEN_FN void load_lane(Word (&words)[N], int lane, const std::uint32_t* from) {
  for (std::size_t i = 0; i < N; ++i) {
    std::memcpy(reinterpret_cast<char*>(&words[i]) + sizeof(std::uint32_t) * static_cast<std::size_t>(lane),
                from + i, sizeof(std::uint32_t));
  }
}

/// The rollouts in work. `L`: a model's functions in lanes.
template <class L>
class RolloutLanes {
  using Model = typename L::Model;

 public:
  explicit RolloutLanes(hypgen_lanes::Rollouts& work)
      : work_(work), params_(*static_cast<const typename Model::Params*>(work.params)) {}

  void run() {
    constexpr std::uint64_t kStepsAtOnce = 8;
    while (true) {
      for (int lane = 0; lane < kLanes && next_ < work_.count; ++lane) {
        if ((active_ >> lane & 1) == 0) start(lane);
      }
      if (active_ == 0) break;
      std::uint64_t taken = 0;
      for (std::uint64_t i = 0; i < kStepsAtOnce; ++i) {
        taken += static_cast<std::uint64_t>(__builtin_popcount(active_));
        step();
        if (active_ != all() && (next_ < work_.count || active_ == 0)) break;
      }
      if (work_.count_steps(work_.clock, taken)) return;
    }
    work_.met_nan = work_.met_nan || any(nan_);
  }

 private:
  static constexpr std::uint32_t all() {
    return static_cast<std::uint32_t>((std::uint64_t{1} << kLanes) - 1);
  }

  void start(int lane) {
    const std::size_t item = next_++;
    item_[lane] = item;
    load_lane(fixed_.words, lane,
              static_cast<const typename Model::Fixed*>(work_.fixed)[work_.scenarios[item]].words);
    load_lane(state_.words, lane, static_cast<const typename Model::State*>(work_.states)[item].words);
    if constexpr (Model::kHasHistory) {
      load_lane(history_.words, lane,
                static_cast<const typename Model::History*>(work_.histories[item])->words);
    }
    number_.set(lane, work_.first_number + work_.numbers[item]);
    taken_.set(lane, 0);
    total_.set(lane, 0.0F);
    active_ |= 1U << lane;
    on_.v[lane] = -1;
  }

  void step() {
    const Mask on = on_;
    Draws draws({work_.key0, work_.key1}, number_,
                as<std::uint32_t>(taken_) + Word(static_cast<std::uint32_t>(work_.depth)));
    const Int action = L::default_policy(on, params_, fixed_, state_, history_, draws);
    const Mask stepped = both(on, action >= Int(0));
    typename L::State next;
    const StepLanes result = L::step(stepped, params_, fixed_, state_, action, draws, next);
    nan_ = either(nan_, both(stepped, result.error));
    if constexpr (!kRewardsFit<Model>) nan_ = either(nan_, both(stepped, math::is_saturated(result.reward)));
    const Float earned = math::from_fixed<kRewardBits<Model>>(result.reward);
    const Float discount =
        entries(work_.discounts, static_cast<std::size_t>(work_.depth_limit - work_.depth + 1), taken_);
    assign(stepped, total_, total_ + discount * earned);
    const Mask goes_on = without(stepped, result.terminal);
    if constexpr (Model::kHasHistory) {
      typename L::History after;
      L::roll_history(goes_on, params_, fixed_, state_, action, draws, next, history_, after);
      assign(goes_on, history_, after);
    }
    assign(goes_on, state_, next);
    assign(goes_on, taken_, taken_ + Int(1));
    const Mask at_limit = both(goes_on, taken_ >= Int(work_.depth_limit - work_.depth));
    if (any(at_limit) && !work_.at_horizon) {
      const float last = work_.discounts[work_.depth_limit - work_.depth];
      assign(at_limit, total_, total_ + Float(last) * L::tail(at_limit, params_, fixed_, state_));
    }
    end(without(on, without(goes_on, at_limit)));
  }

  void end(Mask ended) {
    for (std::uint32_t left = bits_of(ended); left != 0; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      work_.lowers[item_[lane]] = total_[lane];
    }
    active_ &= ~bits_of(ended);
    on_ = without(on_, ended);
  }

  hypgen_lanes::Rollouts& work_;
  const typename Model::Params& params_;
  std::size_t next_ = 0;      // item
  std::uint32_t active_ = 0;  // the lanes in use as bits
  Mask on_;                   // and as a mask
  Mask nan_;
  std::size_t item_[kLanes] = {};
  typename L::Fixed fixed_;
  typename L::State state_;
  typename L::History history_;
  Word number_;  // by which it draws
  Int taken_;    // steps
  Float total_;
};

template <class L>
void roll(hypgen_lanes::Rollouts& work) {
  RolloutLanes<L>(work).run();
}

/// A model without a history.
struct NoHistoryLanes {
  struct History {};
};

}  // namespace hypgen::lanes
