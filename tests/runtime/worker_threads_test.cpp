// SPDX-License-Identifier: Apache-2.0
#include "hypgen/search/worker_threads.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>

namespace hypgen {
namespace {

using std::chrono::milliseconds;

constexpr Clock::time_point kNoDeadline = Clock::time_point::max();

void wait_for(const std::atomic<std::size_t>& count, std::size_t wanted) {
  while (count.load() < wanted) std::this_thread::yield();
}

TEST(WorkerThreads, EachDoesTheWorkOnceARound) {
  std::atomic<std::size_t> done{0};
  std::vector<std::size_t> times(4, 0);  // plain: `park` makes it visible
  WorkerThreads threads(3, [&](std::size_t thread) {
    ++times[thread];
    done.fetch_add(1);
  });
  EXPECT_EQ(threads.size(), 3U);
  EXPECT_EQ(threads.park(kNoDeadline), 0U);
  for (std::size_t round = 1; round <= 200; ++round) {
    threads.start();
    wait_for(done, 3 * round);
    ASSERT_EQ(threads.park(kNoDeadline), 0U);
    ASSERT_EQ(times, (std::vector<std::size_t>{0, round, round, round}));
  }
}

// Each round writes plain memory that the threads read: under ThreadSanitizer a thread that is late is found.
TEST(WorkerThreads, NobodyIsAtWorkOnceAllAreParked) {
  std::size_t number = 0;
  std::atomic<std::size_t> begun{0};
  WorkerThreads threads(4, [&](std::size_t) { begun.fetch_add(number == 0 ? 1000000 : 1); });
  for (number = 1; number <= 2000; ++number) {
    threads.start();
    if (number % 2 == 0) std::this_thread::yield();
    ASSERT_EQ(threads.park(kNoDeadline), 0U);
  }
  const std::size_t last = begun.load();
  EXPECT_LE(last, 4U * 2000U);
  std::this_thread::sleep_for(milliseconds(5));
  EXPECT_EQ(begun.load(), last);
}

TEST(WorkerThreads, DoNotWaitForAThreadThatIsLateBeyondTheDeadline) {
  std::atomic<bool> may_end{false};
  std::atomic<std::size_t> begun{0};
  WorkerThreads threads(2, [&](std::size_t thread) {
    begun.fetch_add(1);
    while (thread == 2 && !may_end.load()) std::this_thread::yield();
  });
  threads.start();
  wait_for(begun, 2);
  while (threads.park(Clock::now()) > 1) std::this_thread::yield();
  EXPECT_EQ(threads.park(Clock::now()), 1U);
  EXPECT_EQ(threads.park(Clock::now() + milliseconds(5)), 1U);
  may_end.store(true);
  EXPECT_EQ(threads.park(kNoDeadline), 0U);
  threads.start();
  wait_for(begun, 4);
}

TEST(WorkerThreads, OthersDoTheNextRoundWhileOneIsLate) {
  std::atomic<bool> may_end{false};
  std::atomic<std::size_t> begun{0};
  std::size_t round = 1;  // plain: read by those that begin
  WorkerThreads threads(3, [&](std::size_t thread) {
    const bool is_first = round == 1;
    begun.fetch_add(1);
    while (is_first && thread == 3 && !may_end.load()) std::this_thread::yield();
  });
  threads.start();
  wait_for(begun, 3);
  while (threads.park(Clock::now()) > 1) std::this_thread::yield();
  for (round = 2; round <= 500; ++round) {
    begun.store(0);
    threads.start();
    wait_for(begun, 2);
    ASSERT_EQ(threads.park_round(kNoDeadline), 0U);
    ASSERT_EQ(threads.park(Clock::now()), 1U);
  }
  may_end.store(true);
  EXPECT_EQ(threads.park(kNoDeadline), 0U);
  begun.store(0);
  threads.start();
  wait_for(begun, 3);
}

TEST(WorkerThreads, TheDestructorWaitsForThoseAtWork) {
  std::atomic<std::size_t> begun{0}, ended{0};
  auto threads = std::make_unique<WorkerThreads>(2, [&](std::size_t) {
    begun.fetch_add(1);
    std::this_thread::sleep_for(milliseconds(5));
    ended.fetch_add(1);
  });
  threads->start();
  wait_for(begun, 2);
  threads.reset();
  EXPECT_EQ(ended.load(), 2U);
}

#if !defined(__SANITIZE_THREAD__) && \
    !defined(__SANITIZE_ADDRESS__)  // these reserve most addresses themselves
std::size_t address_space() {
  unsigned long pages = 0;
  std::FILE* const file = std::fopen("/proc/self/statm", "r");
  if (file == nullptr || std::fscanf(file, "%lu", &pages) != 1) pages = 0;
  if (file != nullptr) std::fclose(file);
  return pages * 4096;
}

// There is room for the stacks of some only.
TEST(WorkerThreads, GoOnWithThoseThatTheSystemGives) {
  const std::size_t in_use = address_space();
  if (in_use == 0) GTEST_SKIP() << "no /proc";
  rlimit before{};
  getrlimit(RLIMIT_AS, &before);
  rlimit tight = before;
  tight.rlim_cur = in_use + (std::size_t{64} << 20);
  ASSERT_EQ(setrlimit(RLIMIT_AS, &tight), 0);
  std::atomic<std::size_t> done{0};
  {
    WorkerThreads threads(500, [&](std::size_t) { done.fetch_add(1); });
    setrlimit(RLIMIT_AS, &before);
    EXPECT_LT(threads.size(), 500U);
    threads.start();
    wait_for(done, threads.size());
    EXPECT_EQ(threads.park(kNoDeadline), 0U);
  }
}
#endif

}  // namespace
}  // namespace hypgen
