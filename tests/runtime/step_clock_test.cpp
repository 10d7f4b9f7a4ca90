// SPDX-License-Identifier: Apache-2.0
// A thread that simulates looks at the clock often enough, however dear a step is.
#include "hypgen/leaves/step_clock.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "hypgen/leaves/rollout.hpp"
#include "test_models.hpp"

namespace hypgen {
namespace {

using std::chrono::microseconds;

void work_for(microseconds time) {
  const Clock::time_point end = Clock::now() + time;
  while (Clock::now() < end) continue;
}

TEST(StepClock, NeverEndsWithoutADeadline) {
  StepClock clock;
  clock.begin_search({});
  EXPECT_FALSE(clock.add(1'000'000'000));
  EXPECT_FALSE(clock.is_over());
  EXPECT_GT(clock.steps_to_look(), 100);
}

TEST(StepClock, StaysOverUntilTheNextSearch) {
  StepClock clock;
  clock.begin_search(Clock::now());
  EXPECT_TRUE(clock.add(1));
  EXPECT_TRUE(clock.add(1));
  EXPECT_EQ(clock.steps_to_look(), 1);
  clock.begin_search(Clock::now() + std::chrono::hours(1));
  EXPECT_FALSE(clock.add(1));
  EXPECT_FALSE(clock.is_over());
  EXPECT_EQ(clock.steps(), 3U);
}

TEST(StepClock, LooksAtEachStepThatIsDear) {
  std::atomic<bool> is_cancelled{false};
  StepClock clock;
  clock.begin_search({Clock::time_point::max(), &is_cancelled});
  for (int i = 0; i < 100; ++i) {
    work_for(microseconds(60));
    ASSERT_FALSE(clock.add(1));
    EXPECT_EQ(clock.steps_to_look(), 1);
  }
  is_cancelled = true;
  EXPECT_TRUE(clock.add(1));
}

// Two threads on one core take turns. The clock learns how long the other's turn is, and ends a search before a
// turn that would pass the deadline.
TEST(StepClock, EndsBeforeAPauseThatWouldPassTheDeadline) {
  const int core = sched_getcpu();
  std::atomic<bool> goes_on{true};
  const auto stay = [core] {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(core, &one);
    pthread_setaffinity_np(pthread_self(), sizeof one, &one);
  };
  std::thread other([&] {
    stay();
    while (goes_on.load(std::memory_order_relaxed)) continue;
  });
  std::thread mine([&] {
    stay();
    StepClock clock;
    clock.learn_pauses();
    int early = 0;
    for (int i = 0; i < 10; ++i) {
      const Clock::time_point end = Clock::now() + std::chrono::milliseconds(60);
      clock.begin_search(end);
      while (!clock.add(1)) work_for(microseconds(20));
      early += Clock::now() < end - std::chrono::milliseconds(1) ? 1 : 0;
    }
    EXPECT_GT(early, 0);
  });
  mine.join();
  goes_on = false;
  other.join();
}

// Its twentieth step cancels the plan.
struct Dear : testing::Tiger {
  inline static int steps = 0;
  inline static std::atomic<bool> is_cancelled{false};

  template <class D>
  static StepResult step(const Params& params, const Fixed& fixed, const State& state, int action, D& draws,
                         State& next) {
    work_for(microseconds(60));
    if (++steps == 20) is_cancelled = true;
    return Tiger::step(params, fixed, state, action, draws, next);
  }
};

TEST(StepClock, EndsARolloutAtADearStep) {
  constexpr int kDepth = 1000;
  SearchSetup setup;
  setup.depth_limit = kDepth;
  setup.deadline = {Clock::time_point::max(), &Dear::is_cancelled};
  StepClock clock;
  DrawCache cache(1, 1);
  const Dear::Params params{0.85F};
  EvaluatorOptions options;
  options.max_depth = kDepth;
  Rollout<Dear> rollout(params, cache, clock, options);
  cache.begin_search(setup.key, 0);
  clock.begin_search(setup.deadline);
  rollout.begin_search(setup);
  rollout.bounds(Dear::Fixed{}, Dear::State{}, Dear::History{}, 0, 0);
  EXPECT_TRUE(clock.is_over());
  EXPECT_EQ(Dear::steps, 20);
}

}  // namespace
}  // namespace hypgen
