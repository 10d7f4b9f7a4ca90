// SPDX-License-Identifier: Apache-2.0
// The value of a scenario from a state on: the model's bounds and the default policy's return.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "hypgen/leaves/draw_cache.hpp"
#include "hypgen/leaves/horizon_floors.hpp"
#include "hypgen/leaves/lane_choice.hpp"
#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/leaves/rollout_queue.hpp"
#include "hypgen/leaves/rollout_step.hpp"
#include "hypgen/leaves/step_clock.hpp"
#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen {

// A scenario's bounds, fixed point.
struct ScenarioBounds {
  std::int64_t upper;
  std::int64_t lower;
};

// Evaluates states of one search. A rollout that `clock` ends has no value: its caller asks the clock.
template <class M>
class Rollout {
 public:
  Rollout(const typename M::Params& params, DrawCache& cache, StepClock& clock,
          const EvaluatorOptions& options)
      : params_(params),
        cache_(cache),
        clock_(clock),
        kernel_(options.lanes),
        waiting_(options.lanes != nullptr),
        choice_(options.measures_lanes),
        floors_(horizon_floors<M>(options.discount, options.max_depth)) {
    double power = 1.0;
    for (int t = 0; t <= options.max_depth; ++t, power *= options.discount) {
      discounts_.push_back(static_cast<float>(power));
    }
  }

  // Whether a state that is not rolled out has a lower bound in this search.
  bool has_floor() const { return !at_horizon_ || kHasLeastReward<M>; }

  // Bounds without a rollout: `lower` is the floor, where the model declares no lower bound.
  ScenarioBounds cheap_bounds(const typename M::Fixed& fixed, const typename M::State& state, int depth) {
    if (at_horizon_ && depth >= depth_limit_) return {0, 0};
    const float upper = M::upper(params_, fixed, state);
    const float floor = at_horizon_ ? floors_[static_cast<std::size_t>(depth_limit_ - depth)]
                                    : M::tail(params_, fixed, state);
    nan_ |= math::is_nan(upper) || math::is_nan(floor);
    const std::int64_t most = math::to_fixed<kRewardBits<M>>(upper);
    return {most, std::min(most, math::to_fixed<kRewardBits<M>>(floor))};
  }

  void begin_search(const SearchSetup& setup) {
    depth_limit_ = setup.depth_limit;
    at_horizon_ = setup.at_horizon;
    nan_ = false;
  }

  ScenarioBounds bounds(const typename M::Fixed& fixed, const typename M::State& state,
                        const typename M::History& history, std::uint32_t scenario, int depth) {
    if (at_horizon_ && depth >= depth_limit_) return {0, 0};
    const float upper = M::upper(params_, fixed, state);
    float lower = 0.0F;
    if (M::kHasLower && depth < depth_limit_) {
      lower = M::lower(params_, fixed, state, history);
    } else {
      lower = default_return(fixed, state, history, scenario, depth);
    }
    nan_ |= math::is_nan(upper) || math::is_nan(lower);
    return {math::to_fixed<kRewardBits<M>>(upper), math::to_fixed<kRewardBits<M>>(lower)};
  }

  // Whether to play rollouts from that depth, `most` of them, side by side: by `begin`, `play` and `end`.
  bool in_lanes(int depth, std::size_t most) {
    return kernel_ != nullptr && depth < depth_limit_ && choice_.takes(most);
  }

  // Bounds of a state of a scenario whose rollout waits: `lower` is its place in the queue. It draws with
  // `number`. The history stays where it is until `play`.
  ScenarioBounds begin(const typename M::Fixed& fixed, std::uint32_t scenario, const typename M::State& state,
                       const typename M::History& history, std::uint32_t number) {
    const float upper = M::upper(params_, fixed, state);
    nan_ |= math::is_nan(upper);
    const std::size_t place = waiting_.add(scenario, state, history, number);
    return {math::to_fixed<kRewardBits<M>>(upper), static_cast<std::int64_t>(place)};
  }
  bool has_room(std::size_t rollouts) const { return waiting_.has_room(rollouts); }

  // Plays all rollouts that wait, from a depth on. `fixed`: of all scenarios. False if time is over.
  bool play(const typename M::Fixed* fixed, int depth) {
    const std::size_t count = waiting_.states.size();
    std::size_t played = 0;
    if (choice_.wants_sample()) {
      played = std::min(LaneChoice::kSample, count);
      play_alone(fixed, depth, 0,
                 played);  // leaves their words in the cache, as leaves before would have done
      const std::uint64_t before = clock_.steps();
      choice_.begin();
      play_alone(fixed, depth, 0, played);
      choice_.end_alone(clock_.steps() - before);
    }
    while (played < count && !clock_.is_over()) {
      const std::size_t wide = choice_.next(count - played);
      if (wide == 0) {
        play_alone(fixed, depth, played, count);
        break;
      }
      const std::uint64_t before = clock_.steps();
      choice_.begin();
      play_in_lanes(fixed, depth, played, wide);
      choice_.end_in_lanes(clock_.steps() - before);
      played += wide;
    }
    waiting_.clear();
    return !clock_.is_over();
  }

  // The lower bound of a state whose rollout was played.
  std::int64_t end(const ScenarioBounds& begun) {
    const float lower = waiting_.earned[static_cast<std::size_t>(begun.lower)];
    nan_ |= math::is_nan(lower);
    return math::to_fixed<kRewardBits<M>>(lower);
  }

  bool met_nan() const { return nan_; }
  void note_error(bool error) { nan_ |= error; }

 private:
  // float32 terms in step order, then the tail bound of the state reached at the depth limit, if the episode
  // goes on there. A state without legal actions is worth nothing.
  float default_return(const typename M::Fixed& fixed, typename M::State state, typename M::History history,
                       std::uint32_t scenario, int depth) {
    float total = 0.0F;
    const float* discount = discounts_.data();
    for (int t = depth; t < depth_limit_;) {
      const int first = t, end = std::min(depth_limit_, t + clock_.steps_to_look());
      bool goes_on = true;
      for (; goes_on && t < end; ++t, ++discount) {
        SearchDraws draws(cache_, scenario, static_cast<std::uint32_t>(t));
        goes_on = roll_step<M>(params_, fixed, draws, *discount, state, history, total, nan_);
      }
      const bool is_over = clock_.add(static_cast<std::uint64_t>(t - first));
      if (!goes_on || is_over) return total;
    }
    if (at_horizon_) return total;
    return total + *discount * M::tail(params_, fixed, state);
  }

  void play_alone(const typename M::Fixed* fixed, int depth, std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      const typename M::Fixed& own = fixed[waiting_.scenarios[i]];
      const auto* const history = static_cast<const typename M::History*>(waiting_.histories[i]);
      waiting_.earned[i] = default_return(own, waiting_.states[i], *history, waiting_.numbers[i], depth);
    }
  }

  void play_in_lanes(const typename M::Fixed* fixed, int depth, std::size_t first, std::size_t count) {
    const auto count_steps = [](void* clock, std::uint64_t steps) {
      return static_cast<StepClock*>(clock)->add(steps);
    };
    hypgen_lanes::Rollouts work{count,
                                &params_,
                                fixed,
                                waiting_.states.data() + first,
                                waiting_.histories.data() + first,
                                waiting_.scenarios.data() + first,
                                waiting_.numbers.data() + first,
                                cache_.first(),
                                cache_.key().key0,
                                cache_.key().key1,
                                depth,
                                depth_limit_,
                                at_horizon_,
                                discounts_.data(),
                                waiting_.earned.data() + first,
                                false,
                                count_steps,
                                &clock_};
    kernel_->roll(work);
    nan_ |= work.met_nan;
  }

  const typename M::Params& params_;
  DrawCache& cache_;
  StepClock& clock_;
  const hypgen_lanes::Kernel* kernel_;  // null: there are no lanes
  RolloutQueue<M> waiting_;
  LaneChoice choice_;
  std::vector<float> discounts_;
  std::vector<float> floors_;  // by steps that are left
  int depth_limit_ = 0;
  bool at_horizon_ = false;
  bool nan_ = false;
};

// Bounds of states met at one scenario and depth. Many actions lead to the same state (sensing actions leave
// it alone), and equal states with equal histories have equal bounds, as draws do not depend on the action. A
// later state may take an earlier one's slot.
template <class M>
class BoundsMemo {
 public:
  void clear() { ++stamp_; }

  template <class Compute>
  ScenarioBounds find_or(const typename M::State& state, const typename M::History& history,
                         const Compute& compute) {
    const Start start{history, state};
    Slot& slot = slots_[hash(start)];
    if (slot.stamp != stamp_ || std::memcmp(&slot.start, &start, sizeof start) != 0) {
      slot.bounds = compute();
      slot.start = start;
      slot.stamp = stamp_;
    }
    return slot.bounds;
  }

 private:
  static constexpr unsigned kSlotBits = 6;
  // What a rollout starts from. A history that is empty takes no room as a base.
  struct Start : M::History {
    typename M::State state;
  };
  struct Slot {
    std::uint64_t stamp;
    ScenarioBounds bounds;
    Start start;
  };

  static std::uint32_t hash(const Start& start) {
    std::uint32_t words[sizeof start / 4];
    std::memcpy(words, &start, sizeof words);
    std::uint32_t value = 0;
    for (const std::uint32_t word : words) value = (value ^ word) * 0x9E3779B1U + 0x7F4A7C15U;
    return value >> (32 - kSlotBits);  // the upper bits: the product carries upwards only
  }

  std::uint64_t stamp_ = 0;
  Slot slots_[std::size_t{1} << kSlotBits] = {};
};

}  // namespace hypgen
