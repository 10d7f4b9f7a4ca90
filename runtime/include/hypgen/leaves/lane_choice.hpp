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

  // Whether to play the rollouts of a leaf side by side: `most` of them, or fewer where some are equal. What was
  // slower is tried again now and then.
  bool takes(std::size_t most) {
    std::size_t size = 0;
    while (size + 1 < kSizes && most >> (size + 1) != 0) ++size;
    leaf_ = &leaves_[size];
    if (!measures_ || leaf_->cost < alone_) return true;
    return ++leaf_->passed % kAgain == 0;
  }

  // Whether some rollouts of a leaf that was taken are to be played one by one, to know what that costs.
  bool wants_sample() { return measures_ && taken_++ % kAgain == 0; }

  void begin() { began_ = Clock::now(); }
  void end_alone(std::uint64_t steps) { note(alone_, steps); }
  void end_in_lanes(std::uint64_t steps) { note(leaf_->cost, steps); }

 private:
  static constexpr std::size_t kSizes = 12;  // up to 1, 3, 7 .. rollouts
  static constexpr std::uint32_t kAgain = 256;

  static constexpr double kUnknown = 1e30;

  struct Leaves {
    double cost = 0.0;  // nanoseconds a step; 0: not known yet
    std::uint32_t passed = 0;
  };

  // A pause of the thread counts little.
  void note(double& cost, std::uint64_t steps) const {
    if (steps == 0) return;
    const std::chrono::duration<double, std::nano> passed = Clock::now() - began_;
    const double found = passed.count() / static_cast<double>(steps);
    cost = cost == 0.0 || cost >= kUnknown ? found : cost + (std::min(found, 2.0 * cost) - cost) / 8.0;
  }

  bool measures_;
  Leaves leaves_[kSizes];
  Leaves* leaf_ = &leaves_[0];
  double alone_ = kUnknown;  // lanes are tried first
  std::uint32_t taken_ = 0;
  Clock::time_point began_{};
};

}  // namespace hypgen
