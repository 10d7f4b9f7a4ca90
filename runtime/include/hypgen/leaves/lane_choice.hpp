// SPDX-License-Identifier: Apache-2.0
// Whether rollouts are sooner played side by side or one by one: measured, as it depends on model, processor and
// leaf. The results are the same.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace hypgen {

// What a step has cost either way. Side by side it depends on how many rollouts there are to fill the lanes.
class LaneChoice {
  using Clock = std::chrono::steady_clock;

 public:
  // How many rollouts show what one costs by itself.
  static constexpr std::size_t kSample = 4;

  // `measures`: whether to leave out what is slower. If not, lanes play all.
  explicit LaneChoice(bool measures) : measures_(measures) {}

  // Whether the rollouts of a leaf wait for each other: `most` of them, or fewer where some are equal. What was
  // slower is tried again now and then.
  bool takes(std::size_t most) {
    std::size_t size = 0;
    while (size + 1 < kSizes && most >> (size + 1) != 0) ++size;
    leaf_ = &leaves_[size];
    const bool is_faster = leaf_->cost != 0.0 && leaf_->cost < alone_;
    tries_ = !is_faster && (leaf_->cost == 0.0 || ++leaf_->passed % kAgain == 0);
    return !measures_ || is_faster || tries_;
  }

  // How many of the leaf's rollouts to play side by side next; 0: none of them. A trial takes few.
  std::size_t next(std::size_t waiting) {
    if (!measures_) return waiting;
    if (!tries_) return leaf_->cost < alone_ ? waiting : 0;
    tries_ = false;
    return std::min(kTrial, waiting);
  }

  // Whether some rollouts of a leaf that was taken are to be played one by one, to know what that costs.
  bool wants_sample() { return measures_ && taken_++ % kAgain == 0; }

  void begin() { began_ = Clock::now(); }
  void end_alone(std::uint64_t steps) { note(alone_, steps); }
  void end_in_lanes(std::uint64_t steps) { note(leaf_->cost, steps); }

 private:
  static constexpr std::size_t kSizes = 12;  // up to 1, 3, 7 .. rollouts
  static constexpr std::uint32_t kAgain = 256;
  static constexpr std::size_t kTrial = 128;  // fills 16 lanes several times over

  struct Leaves {
    double cost = 0.0;  // nanoseconds a step; 0: not known yet
    std::uint32_t passed = 0;
  };

  // A pause of the thread counts little.
  void note(double& cost, std::uint64_t steps) const {
    if (steps == 0) return;
    const std::chrono::duration<double, std::nano> passed = Clock::now() - began_;
    const double found = passed.count() / static_cast<double>(steps);
    cost = cost == 0.0 ? found : cost + (std::min(found, 2.0 * cost) - cost) / 8.0;
  }

  bool measures_;
  Leaves leaves_[kSizes];
  Leaves* leaf_ = &leaves_[0];
  double alone_ = 0.0;
  bool tries_ = false;  // the leaf in work is a trial
  std::uint32_t taken_ = 0;
  Clock::time_point began_{};
};

}  // namespace hypgen
