// Tree search by one thread or several.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "hypgen/search/search_thread.hpp"
#include "hypgen/search/worker_threads.hpp"

namespace hypgen {

// The caller's thread searches, and others that sleep between searches. Allocates only when it is made.
class Search {
 public:
  // `threads` of the tree's options is how many search, the caller among them; fewer if the system refuses
  // some.
  Search(const PlannerOptions& options, const TreeOptions& tree);

  // Waits, until the deadline, for threads that the last search left behind, and gives how many still have
  // not ended. To be called before anything that they may use is changed.
  std::size_t park(Clock::time_point deadline) { return workers_.park(deadline); }

  // Searches until a limit is reached or something fails, and fills `decision` but for its action. Rows of
  // the evaluator's stay in use until the next search.
  // `actions`, ascending, are those that the root has; none: all that are legal.
  void run(LeafEvaluator& evaluator, const RootResult& root, const SearchSetup& setup,
           Span<const int> actions, Decision& decision);

  // The best lower bound; the default policy's action if it is as good, or if following the policy is. Of
  // POMCP the best mean value.
  int best_action(int default_action) const;

  std::size_t threads() const { return shared_.threads.size(); }
  const Tree& tree() const { return shared_.tree; }

  // Adds how many leaves were expanded in all searches: entry n counts those with n scenarios.
  void add_leaf_sizes(std::vector<std::uint64_t>& leaf_sizes);

 private:
  void add_counts(Decision& decision) const;

  SharedSearch shared_;
  WorkerThreads workers_;  // after what they use
};

}  // namespace hypgen
