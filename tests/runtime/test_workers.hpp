// SPDX-License-Identifier: Apache-2.0
// Threads that share the work of a belief.
#pragma once

#include <atomic>
#include <thread>
#include <vector>

#include "hypgen/core/workers.hpp"

namespace hypgen::testing {

class Threads final : public Workers {
 public:
  explicit Threads(int count) : count_(count) {}

  void share(std::size_t count, const Job& job) override {
    std::atomic<std::size_t> next{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < count_; ++i) {
      threads.emplace_back([&] {
        for (std::size_t number = next++; number < count; number = next++) job(number);
      });
    }
    for (std::thread& thread : threads) thread.join();
  }

 private:
  int count_;
};

}  // namespace hypgen::testing
