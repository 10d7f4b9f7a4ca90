// SPDX-License-Identifier: Apache-2.0
// Counts allocations by replacing the global operators. They are not inlined: the compiler would take their
// malloc and free for a mismatch with new and delete.

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "test_solvers.hpp"

namespace {
std::atomic<long> allocations{0};
}

__attribute__((noinline)) void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
__attribute__((noinline)) void operator delete(void* memory) noexcept { std::free(memory); }
__attribute__((noinline)) void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace hypgen::testing {
namespace {

TEST(Allocation, NoneInASearch) {
  for (const Mode mode : {Mode::kDespot, Mode::kParallel, Mode::kGpu, Mode::kHyp, Mode::kPomcp,
                          Mode::kRollout, Mode::kDefault}) {
    PlannerOptions options = trials(50);
    options.mode = mode;
    options.threads = has_many_threads(mode) ? 3 : 1;
    options.in_flight = wants_gpu(mode) ? 16 : options.threads;
    Solver solver(rock_sample_descriptor<4, 3>(), options);
    const long before = allocations;
    const Decision decision = solver.plan();
    const Decision again = solver.plan(1);
    EXPECT_EQ(allocations, before);
    EXPECT_EQ(decision.trials, again.trials);
  }
}

TEST(Allocation, NoneInABeliefUpdate) {
  Solver solver(tiger_descriptor(), trials(1));
  const long before = allocations;
  for (int i = 0; i < 5; ++i) solver.see(0, 0);
  EXPECT_EQ(allocations, before);
}

}  // namespace
}  // namespace hypgen::testing
