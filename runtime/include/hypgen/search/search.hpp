// SPDX-License-Identifier: Apache-2.0
// Tree search by one thread or several.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "hypgen/core/workers.hpp"
#include "hypgen/search/search_thread.hpp"
#include "hypgen/search/worker_threads.hpp"

namespace hypgen {

// A search by the caller's thread and by worker threads, which sleep between searches and share other jobs
// then. Only the constructor allocates.
class Search final : public Workers {
 public:
  // `tree.threads` threads search, the caller included; fewer if the system refuses some.
  Search(const PlannerOptions& options, const TreeOptions& tree);

  // Waits until the deadline for threads that the last search left behind; gives how many have not ended. The
  // caller calls this before it changes anything that those threads may use.
  std::size_t park(Clock::time_point deadline) { return workers_.park(deadline); }

  // Threads that the last search left behind join in when they have ended. Between searches.
  void share(std::size_t count, const Job& job) override {
    share_until(count, job, Clock::time_point::max());
  }

  // The same, but gives at the deadline how many threads have not ended. They use `job` until they are parked,
  // and the caller does all jobs alone until then.
  std::size_t share_until(std::size_t count, const Job& job, Clock::time_point deadline);

  // Searches until a limit or a failure, and fills all of `decision` but its action. The tree uses the
  // evaluator's rows until the next search. `actions`, ascending, are those of the root; empty: all.
  void run(LeafEvaluator& evaluator, const RootResult& root, const SearchSetup& setup,
           Span<const int> actions, Decision& decision);

  // Gives the action with the best lower bound, or the best mean value of POMCP. `default_action` goes before
  // actions of the same bound, and before all actions whose bound is no better than the default policy's.
  int best_action(int default_action) const;

  // What looking further ahead has added to the lower bound of a root's action since its expansion, as a mean of
  // the scenarios; 0 for an action that the root does not have.
  double improvement(int action) const;

  // The root's actions in the evaluator's order; none before the root is expanded. While all threads are parked.
  std::vector<RootAction> root_actions() const;

  std::size_t threads() const { return shared_.threads.size(); }
  const Tree& tree() const { return shared_.tree; }

  // Gives the next search another lambda. While all threads are parked.
  void set_pruning(double pruning) { shared_.tree.set_pruning(pruning); }

  // Leaves no tree, before the evaluator begins another search. While all threads are parked.
  void clear() { shared_.tree.clear(); }

  // Adds the numbers of leaves expanded in all searches: entry n counts leaves with n scenarios.
  void add_leaf_sizes(std::vector<std::uint64_t>& leaf_sizes);

 private:
  void work(std::size_t thread);
  void do_jobs();
  void add_counts(Decision& decision) const;

  SharedSearch shared_;
  // What the threads share; null: a search. The caller sets it, and how many jobs there are, while they sleep.
  const Job* job_ = nullptr;
  std::size_t job_count_ = 0;
  bool has_left_jobs_ = false;            // threads may be at work on those
  std::atomic<std::size_t> next_job_{0};  // each number is taken once; relaxed, as the lock orders all else
  WorkerThreads workers_;                 // last: they use `shared_`
};

}  // namespace hypgen
