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

// The caller is thread 0 and works itself; these are 1 .. size(). Its lock is taken once by each thread when
// it begins and when it ends, never in between. Allocates only when it is made.
class WorkerThreads {
 public:
  using Work = std::function<void(std::size_t thread)>;

  // Starts `count` threads, or as many as the system gives. `work` has to end soon once it cannot go on.
  WorkerThreads(std::size_t count, Work work);

  // Waits for those that work.
  ~WorkerThreads();

  WorkerThreads(const WorkerThreads&) = delete;
  WorkerThreads& operator=(const WorkerThreads&) = delete;

  std::size_t size() const { return threads_.size(); }

  // Wakes all threads, each of which does the work once. Only while all are parked. They see what the caller
  // wrote before.
  void start();

  // Waits until all are parked, as they then stay; a thread that has not begun does not begin any more. Gives
  // how many are still at work at the deadline. With none the caller sees all that they wrote.
  std::size_t park(Clock::time_point deadline);

 private:
  void live(std::size_t thread);

  Work work_;
  std::mutex lock_;  // guards the rest but for threads_
  std::condition_variable woken_, parked_;
  std::size_t round_ = 0;             // how often work was started: a thread does each at most once
  bool is_open_ = false;              // whether a thread may begin this round's work
  bool is_over_ = false;              // whether threads have to end
  std::size_t working_ = 0;           // threads that have begun and not ended
  std::vector<std::thread> threads_;  // last: they use all of the above
};

}  // namespace hypgen
