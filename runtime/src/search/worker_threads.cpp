// SPDX-License-Identifier: Apache-2.0
#include "hypgen/search/worker_threads.hpp"

#include <exception>
#include <utility>

namespace hypgen {

WorkerThreads::WorkerThreads(std::size_t count, Work work) : work_(std::move(work)) {
  threads_.reserve(count);
  try {
    while (threads_.size() < count) threads_.emplace_back(&WorkerThreads::live, this, threads_.size() + 1);
  } catch (const std::exception&) {
    // A limit of the system or of memory: fewer threads find the same, later.
  }
}

WorkerThreads::~WorkerThreads() {
  {
    const std::lock_guard<std::mutex> guard(lock_);
    is_over_ = true;
  }
  woken_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerThreads::start() {
  {
    const std::lock_guard<std::mutex> guard(lock_);
    late_ += std::exchange(working_, 0);
    ++round_;
    is_open_ = true;
  }
  woken_.notify_all();
}

std::size_t WorkerThreads::park(Clock::time_point deadline) {
  std::unique_lock<std::mutex> guard(lock_);
  close(guard, deadline, [this] { return working_ + late_ == 0; });
  return working_ + late_;
}

std::size_t WorkerThreads::park_round(Clock::time_point deadline) {
  std::unique_lock<std::mutex> guard(lock_);
  close(guard, deadline, [this] { return working_ == 0; });
  return working_;
}

// Lets no thread begin the round any more, and waits.
template <class Done>
void WorkerThreads::close(std::unique_lock<std::mutex>& guard, Clock::time_point deadline,
                          const Done& is_done) {
  is_open_ = false;
  if (deadline == Clock::time_point::max()) {
    parked_.wait(guard, is_done);
  } else {
    parked_.wait_until(guard, deadline, is_done);
  }
}

// What a thread does from its start to its end.
void WorkerThreads::live(std::size_t thread) {
  std::size_t last_round = 0;
  std::unique_lock<std::mutex> guard(lock_);
  while (true) {
    woken_.wait(guard, [&] { return is_over_ || (is_open_ && round_ != last_round); });
    if (is_over_) return;
    last_round = round_;
    ++working_;
    guard.unlock();
    work_(thread);
    guard.lock();
    std::size_t& at_work = last_round == round_ ? working_ : late_;
    if (--at_work == 0) parked_.notify_one();
  }
}

}  // namespace hypgen
