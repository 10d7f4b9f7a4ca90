// SPDX-License-Identifier: Apache-2.0
// Counts allocations by replacing the global operators. They are not inlined: the compiler would take their
// malloc and free for a mismatch with new and delete.

#include <gtest/gtest.h>
#include <hypgen.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <vector>

#include "embedded_rocks.hpp"
#include "hypgen/embed/c_api.hpp"
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

TEST(Allocation, NoneInPlansAndUpdatesOfAnAgent) {
  const hypgen_model model = {&this_runtime, rocks};
  const hypgen_options options = {sizeof options, "mode=despot trials=5 scenarios=20 particles=100 memory=64",
                                  nullptr};
  hypgen_planner* planner = nullptr;
  ASSERT_EQ(hypgen_create(&model, &options, &planner, nullptr), HYPGEN_OK);
  ASSERT_LT(hypgen_warm_up(planner, 0.0, nullptr), HYPGEN_FAILED);
  hypgen_decision decision = {sizeof decision, 0, 0, nullptr, 0, 0, 0, 0, 0, 0, 0, 0};
  long allocated = 0;
  std::uint64_t steps = 0;
  for (std::uint64_t episode = 0; steps < 10000; ++episode) {
    ASSERT_LT(hypgen_reset(planner, nullptr, 0, episode, nullptr), HYPGEN_FAILED);
    const long before = allocations;
    for (int step = 0; step < 50; ++step, ++steps) {
      ASSERT_LT(hypgen_plan(planner, 0.0, &decision, nullptr), HYPGEN_FAILED);
      // Check actions see whether a rock looks good; the others see nothing.
      const std::int32_t seen = decision.action >= 5 ? 1 + static_cast<std::int32_t>(steps % 2) : 0;
      if (hypgen_update_values(planner, decision.action, &seen, 1, nullptr) != HYPGEN_OK) break;
    }
    allocated += allocations - before;
  }
  EXPECT_EQ(allocated, 0);
  EXPECT_EQ(hypgen_destroy(planner), HYPGEN_OK);
}

TEST(Allocation, NoneInAStepOfWorlds) {
  const hypgen_model model = {&this_runtime, rocks};
  const hypgen_worlds_options options = {sizeof options, 5, 0, nullptr, nullptr};
  hypgen_worlds* worlds = nullptr;
  ASSERT_EQ(hypgen_worlds_create(&model, &options, &worlds, nullptr), HYPGEN_OK);
  const std::vector<int32_t> actions(5, 5);
  std::vector<double> rewards(5);
  std::vector<int32_t> seen(5), visible(10);
  hypgen_worlds_results results = {sizeof results, rewards.data(), seen.data(), nullptr,
                                   visible.data(), nullptr,        nullptr,     nullptr};
  const long before = allocations;
  EXPECT_EQ(hypgen_worlds_seed(worlds, 3, nullptr), HYPGEN_OK);
  EXPECT_EQ(hypgen_worlds_reset(worlds, nullptr, nullptr, 5, nullptr), HYPGEN_OK);
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(hypgen_worlds_step(worlds, actions.data(), 5, &results, nullptr), HYPGEN_OK);
  EXPECT_EQ(allocations, before);
  EXPECT_EQ(hypgen_worlds_destroy(worlds), HYPGEN_OK);
}

}  // namespace
}  // namespace hypgen::testing
