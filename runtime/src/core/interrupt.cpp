// SPDX-License-Identifier: Apache-2.0
#include "hypgen/core/interrupt.hpp"

#include <signal.h>
#include <time.h>

#include <atomic>
#include <cstdint>

namespace hypgen {

namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};
constexpr std::int64_t kSameMilliseconds = 100;

// The runtime's one variable outside objects: a signal handler reaches nothing else. The time of the first
// signal in milliseconds, times 256, and its number; 0: none.
std::atomic<std::int64_t> first{0};
static_assert(std::atomic<std::int64_t>::is_always_lock_free);

// Calls nothing but what POSIX allows in a handler.
void on_signal(int signal) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const std::int64_t milliseconds = std::int64_t{now.tv_sec} * 1000 + now.tv_nsec / 1'000'000;
  std::int64_t before = 0;
  if (first.compare_exchange_strong(before, milliseconds * 256 + signal)) return;
  if (milliseconds - before / 256 < kSameMilliseconds) return;
  ::signal(signal, SIG_DFL);
  raise(signal);  // it comes once this handler has returned
}

}  // namespace

void catch_interrupts() {
  first = 0;
  for (const int signal : kSignals) {
    struct sigaction action{};
    if (sigaction(signal, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) continue;
    action = {};
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESTART;
    sigaction(signal, &action, nullptr);
  }
}

bool interrupted() { return first != 0; }

int interrupt_code() { return 128 + static_cast<int>(first % 256); }

}  // namespace hypgen
