// SPDX-License-Identifier: Apache-2.0
// When a plan has to end.
#pragma once

#include <atomic>
#include <chrono>

namespace hypgen {

using Clock = std::chrono::steady_clock;

// A time, or earlier, when another thread raises a flag. Copies share the flag.
class Deadline {
 public:
  Deadline() = default;  // never
  // `is_cancelled` may be null, and outlives all copies otherwise.
  Deadline(Clock::time_point time, const std::atomic<bool>* is_cancelled = nullptr)
      : time_(time), is_cancelled_(is_cancelled) {}

  Clock::time_point time() const { return time_; }
  bool is_limited() const { return time_ != Clock::time_point::max(); }
  bool is_cancelled() const {
    return is_cancelled_ != nullptr && is_cancelled_->load(std::memory_order_relaxed);
  }

  // Whether it will ever pass.
  bool may_pass() const { return is_limited() || is_cancelled_ != nullptr; }
  bool has_passed(Clock::time_point now) const { return now >= time_ || is_cancelled(); }
  bool has_passed() const { return is_cancelled() || (is_limited() && Clock::now() >= time_); }

 private:
  Clock::time_point time_ = Clock::time_point::max();
  const std::atomic<bool>* is_cancelled_ = nullptr;
};

}  // namespace hypgen
