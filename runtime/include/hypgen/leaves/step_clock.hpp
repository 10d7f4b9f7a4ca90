// SPDX-License-Identifier: Apache-2.0
// When a thread that simulates steps looks at the clock.
#pragma once

#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "hypgen/core/deadline.hpp"

namespace hypgen {

// Counts the steps of one thread, and looks at the clock about every 50 microseconds. A step takes ten
// nanoseconds in one model and tens of microseconds in another, so the last steps' cost says when to look next.
//
// A thread that shares its core is stopped for milliseconds again and again. A deadline in such a pause is missed by
// what is left of it. So the clock is over earlier by the longest pause of the last second.
class StepClock {
 public:
  // The first steps of a search may be dearer than the last ones of the search before.
  void begin_search(const Deadline& deadline) {
    past_steps_ += steps_;
    steps_ = looked_at_ = 0;
    next_look_ = deadline.may_pass() ? 1 : UINT64_MAX;
    is_over_ = false;
    const bool is_new_plan = deadline.time() != deadline_.time();
    deadline_ = deadline;
    if (is_new_plan && deadline.is_limited()) begin_plan();
  }

  // Counts steps that were simulated. True once the deadline has passed, as far as the last look can tell.
  bool add(std::uint64_t steps) {
    steps_ += steps;
    return steps_ >= next_look_ && look();
  }

  bool is_over() const { return is_over_; }

  // From now on it ends before pauses. That is for the thread that answers: others that are late are left behind.
  void learn_pauses() { learns_pauses_ = true; }

  // How many steps may be simulated before the next look, at least 1.
  int steps_to_look() const {
    return is_over_ ? 1 : static_cast<int>(std::min(next_look_ - steps_, kMostSteps));
  }

  std::uint64_t steps() const { return past_steps_ + steps_; }

 private:
  static constexpr std::chrono::nanoseconds kBetweenLooks{50'000};
  static constexpr std::chrono::milliseconds kLeastPause{1};
  static constexpr std::chrono::seconds kPauseCounts{1};
  static constexpr std::uint64_t kMostSteps = 512;  // so that steps that become dear are noticed

  // A plan has many searches.
  void begin_plan() {
    last_look_ = Clock::now();
    most_pause_ = (deadline_.time() - last_look_) / 2;
    if (last_look_ - paused_at_ > kPauseCounts) pause_ = {};
  }

  [[gnu::noinline]] bool look() {
    if (is_over_) return true;
    const Clock::time_point now = Clock::now();
    if (learns_pauses_ && (looked_at_ == 0 || now - last_look_ > kLeastPause)) note_pause(now);
    const auto passed = std::max<std::int64_t>(1, std::chrono::nanoseconds(now - last_look_).count());
    const std::uint64_t done = steps_ - looked_at_;
    const std::uint64_t fit = done * static_cast<std::uint64_t>(kBetweenLooks.count()) / passed;
    last_look_ = now;
    looked_at_ = steps_;
    // Twice as many at the most: what else the thread has done between two looks costs time, too.
    next_look_ = steps_ + std::clamp<std::uint64_t>(fit, 1, std::min(2 * done, kMostSteps));
    is_over_ = deadline_.has_passed(now + std::min(pause_, most_pause_));
    if (is_over_) next_look_ = 0;
    return is_over_;
  }

  // What a thread had done by a time: nanoseconds that it had a core, and how often it went to sleep by itself.
  struct Use {
    Clock::time_point time{};
    std::chrono::nanoseconds worked{0};
    long sleeps = -1;
  };

  static Use use(Clock::time_point now) {
    timespec worked{};
    rusage used{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &worked);
    getrusage(RUSAGE_THREAD, &used);
    return {now, std::chrono::seconds(worked.tv_sec) + std::chrono::nanoseconds(worked.tv_nsec),
            used.ru_nvcsw};
  }

  // A thread that waits for others works or sleeps. One that did neither was stopped.
  void note_pause(Clock::time_point now) {
    const Use before = used_;
    used_ = use(now);
    const Clock::duration stopped = (used_.time - before.time) - (used_.worked - before.worked);
    if (used_.sleeps != before.sleeps || stopped < kLeastPause) return;
    pause_ = std::max(pause_, std::min(stopped, now - last_look_));
    paused_at_ = now;
  }

  Deadline deadline_;
  bool is_over_ = false;
  bool learns_pauses_ = false;
  std::uint64_t past_steps_ = 0;  // of earlier searches
  std::uint64_t steps_ = 0;       // of this search
  std::uint64_t looked_at_ = 0;   // the count at the last look
  std::uint64_t next_look_ = 0;   // the count from which on it looks again
  Clock::time_point last_look_{};
  Clock::duration pause_{};       // the longest of late
  Clock::duration most_pause_{};  // that is heeded in this plan: half of its time
  Clock::time_point paused_at_{};
  Use used_;
};

}  // namespace hypgen
