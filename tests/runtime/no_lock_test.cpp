// SPDX-License-Identifier: Apache-2.0
// Threads that search never wait for a lock: a call of futex while they do is counted.
#if defined(__linux__) && defined(__x86_64__) && !defined(__SANITIZE_THREAD__)

#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <thread>

#include "hypgen/search/search.hpp"
#include "test_solvers.hpp"

namespace hypgen::testing {
namespace {

thread_local bool is_searching = false;
std::atomic<int> calls_of_futex{0};

// The call is not made; its result is that of one that was interrupted.
void on_refused_call(int, siginfo_t*, void* context) {
  if (is_searching) ++calls_of_futex;
  static_cast<ucontext_t*>(context)->uc_mcontext.gregs[REG_RAX] = -EAGAIN;
}

// From here on the calling thread's calls of futex raise SIGSYS.
bool refuse_futex() {
  sock_filter filter[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_futex, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog program{sizeof filter / sizeof *filter, filter};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

TEST(NoLock, ThreadsThatSearchNeverCallFutex) {
  struct sigaction action{};
  action.sa_sigaction = on_refused_call;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGSYS, &action, nullptr);

  constexpr std::size_t kThreads = 4;
  PlannerOptions options = trials(20000);
  options.threads = options.in_flight = kThreads;
  const Solver solver(rock_sample_descriptor<4, 3>(), options);
  const auto evaluator = solver.instance->make_evaluator(evaluator_options(options, solver.model));
  ScenarioBuffer scenarios;
  solver.belief->reserve(scenarios, options.scenarios);
  const SearchSetup setup{derive(0, StreamKind::kPlan, 0), options.depth, false, Clock::time_point::max()};
  solver.belief->sample(setup.key, 0, options.scenarios, scenarios);

  SharedSearch shared(options, {options.memory_bytes, options.depth, 0.95, 0.0, kThreads});
  for (std::size_t i = 0; i < kThreads; ++i) {
    shared.threads.push_back(std::make_unique<SearchThread>(shared, i, 1));
  }
  shared.begin(*evaluator, evaluator->begin_search(scenarios, setup), setup, {});
  std::atomic<int> refusing{0};
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < kThreads; ++i) {
    threads.emplace_back([&, i] {
      if (refuse_futex()) ++refusing;
      is_searching = true;
      shared.run_thread(i);
      is_searching = false;
    });
  }
  for (std::thread& thread : threads) thread.join();
  if (refusing.load() < static_cast<int>(kThreads))
    GTEST_SKIP() << "the system lets no thread filter its calls";
  EXPECT_EQ(calls_of_futex, 0);
  EXPECT_GT(shared.threads[0]->counts().expansions.get(), 0U);
}

}  // namespace
}  // namespace hypgen::testing

#endif
