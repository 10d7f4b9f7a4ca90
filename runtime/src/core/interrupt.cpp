// SPDX-License-Identifier: Apache-2.0
#include "hypgen/core/interrupt.hpp"

#include <atomic>
#include <csignal>

namespace hypgen {

namespace {

// The runtime's one variable outside objects: a signal handler reaches nothing else.
std::atomic<bool> was_interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void on_interrupt(int signal) {
  was_interrupted = true;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void catch_interrupts() {
  was_interrupted = false;
  std::signal(SIGINT, on_interrupt);
}

bool interrupted() { return was_interrupted; }

}  // namespace hypgen
