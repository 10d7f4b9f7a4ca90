// SPDX-License-Identifier: Apache-2.0
// Threads that help with one piece of work at a time and sleep in between.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "hypgen/leaves/leaf_evaluator.hpp"

namespace hypgen {

// The caller is thread 0 and works itself; the worker threads are 1 .. size(). A thread takes the lock when
// it begins and when it ends its work, never in between. Only the constructor allocates.
class WorkerThreads {
 public:
  using Work = std::function<void(std::size_t thread)>;

  // Starts `count` threads, or as many as the system gives. `work` ends soon once it cannot go on.
  WorkerThreads(std::size_t count, Work work);

  // Waits for the threads that work.
  ~WorkerThreads();

  WorkerThreads(const WorkerThreads&) = delete;
  WorkerThreads& operator=(const WorkerThreads&) = delete;

  std::size_t size() const { return threads_.size(); }

  // Wakes all threads; each does the work once. One that is still at work on an earlier round does so
  // afterwards, if this round is open then. Threads see what the caller wrote before they have begun.
  void start();

  // Waits until the deadline for all threads to be parked; gives how many are still at work. Threads that
  // have not begun do not begin any more. If none is at work, all stay parked and the caller sees what they
  // wrote.
  std::size_t park(Clock::time_point deadline);

  // The same for the latest round alone: those that work on an earlier one are neither waited for nor counted.
  std::size_t park_round(Clock::time_point deadline);

 private:
  void live(std::size_t thread);
  template <class Done>
  void close(std::unique_lock<std::mutex>& guard, Clock::time_point deadline, const Done& is_done);

  Work work_;
  std::mutex lock_;  // guards the rest but for threads_
  std::condition_variable woken_, parked_;
  std::size_t round_ = 0;             // how often work was started: a thread does each at most once
  bool is_open_ = false;              // whether a thread may begin this round's work
  bool is_over_ = false;              // whether threads have to end
  std::size_t working_ = 0;           // threads that have begun this round and not ended
  std::size_t late_ = 0;              // threads that have not ended an earlier one
  std::vector<std::thread> threads_;  // last: they use all of the above
};

}  // namespace hypgen
