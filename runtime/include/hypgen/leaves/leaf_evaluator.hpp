// The seam between the search, which knows no model, and what simulates the model.
#pragma once

#include <cfenv>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "hypgen/core/span.hpp"
#include "hypgen/core/status.hpp"
#include "hypgen/memory/scenario_buffer.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

using Clock = std::chrono::steady_clock;

// Fixed when an evaluator is made.
struct EvaluatorOptions {
  std::size_t max_scenarios = 500;
  std::size_t memory_bytes = std::size_t{256} << 20;  // for the states and rows of expanded nodes
  double discount = 0.95;
  int max_depth = 90;
  std::size_t in_flight = 1;            // leaves that the search keeps submitted, all threads together
  std::size_t device_memory_bytes = 0;  // of a GPU; 0: half of what is free, at most 8 GB
  int warps = 0;                        // of a GPU that share a step; 0: chosen for each batch
  std::size_t threads = 1;              // of the search
  double patience = 10.0;               // seconds without an answer after which a device is lost
};

// What holds for one search.
struct SearchSetup {
  StreamKey key;
  int depth_limit;  // at most the options' max_depth
  bool at_horizon;  // the episode ends at that depth: nothing is earned from there on
  Clock::time_point deadline;
};

constexpr std::uint64_t kNoHandle = UINT64_MAX;

// A node to expand: the root (parent kNoHandle), or a group of an action of an expanded parent. A group is
// named by its first member; it is not the terminal one.
struct LeafRequest {
  std::uint32_t ticket;
  std::uint64_t parent;
  int action;
  std::uint32_t first;  // ChildRow::first of the group
  std::uint32_t count;  // its scenarios
  int depth;
  Span<const int> actions;  // those to try, ascending; empty: all legal ones. Legal ones count only. They
                            // have to stay until the leaf is given
  // How many actions are rolled out besides the default policy's: those that promise most
  // (rolled_actions.hpp). kRollsAll at the root asks for gains too.
  std::uint32_t rolled = UINT32_MAX;
  std::int64_t lower_sum =
      INT64_MIN;  // what is known of the leaf: an action that promises no more is not rolled
};

// A group of scenarios that saw the same observation after an action. Groups stand in order of first
// appearance; terminal scenarios are a group of their own. Sums are fixed point, of values as seen from the
// child.
struct ChildRow {
  std::int64_t upper_sum;
  std::int64_t lower_sum;
  std::uint32_t first;  // position, among the parent's scenarios, of the group's first
  std::uint32_t count : 31;
  std::uint32_t terminal : 1;
};
static_assert(sizeof(ChildRow) == 24);

// A group's row before anything is added up.
constexpr ChildRow empty_row(std::uint32_t first, std::uint32_t count, bool terminal) {
  return {0, 0, first, count & INT32_MAX, terminal};
}

// An action at the leaf. Bounds are summed over its children; an upper bound below the lower one counts as
// that.
struct ActionRow {
  std::int64_t reward_sum;
  std::int64_t upper_sum;
  std::int64_t lower_sum;
  int action;
  std::uint32_t first_child;  // index into LeafResult::children
  std::uint32_t child_count;
  std::uint32_t padding;  // 0, as rows are compared by their bytes
};
static_assert(sizeof(ActionRow) == 40);

// Of an action at the root: scenario-wise differences of the one-ply return (reward plus discounted lower
// bound) from the default policy's action.
struct Gain {
  std::int64_t sum;
  double square_sum;
};

// An expanded leaf, or why it is not (`status` other than kOk: no rows). Rows are valid until `release`.
struct LeafResult {
  std::uint32_t ticket;
  Status status;
  std::uint64_t handle;
  std::uint32_t count;  // the leaf's scenarios
  Span<const ActionRow> actions;
  Span<const ChildRow> children;
  Span<const Gain> gains;  // at the root, where all actions are rolled out, one for each; else none
};

// What an evaluator has done since it was made. Zero: not known, or nothing.
struct EvaluatorStats {
  std::uint64_t batches = 0;
  std::uint64_t leaves = 0;
  std::uint64_t steps = 0;       // simulated, those of rollouts included
  std::uint64_t bytes_read = 0;  // from a device
  double kernel_seconds = 0.0;   // summed over kernels
  double busy_seconds = 0.0;     // while at least one kernel ran

  void add(const EvaluatorStats& other) {
    batches += other.batches;
    leaves += other.leaves;
    steps += other.steps;
    bytes_read += other.bytes_read;
    kernel_seconds += other.kernel_seconds;
    busy_seconds += other.busy_seconds;
  }
};

// The root's bounds, and the default policy's action there (-1: no action is legal).
struct RootResult {
  Status status;
  ChildRow row;
  int default_action;
};

// Serves the threads of a search, which are numbered from 0. `begin_search`, `release` and `stats` are called
// while none of them is in another call, the rest by each for itself, at any time: a thread has its own
// leaves in flight, below parents that any thread has expanded. Allocates only when it is made.
class LeafEvaluator {
 public:
  virtual ~LeafEvaluator() = default;

  // How many threads it serves: those of its options, or fewer if memory does not suffice.
  virtual std::size_t threads() const { return 1; }

  // How many rollouts take no longer than one: those that its device runs at once.
  virtual std::size_t lanes() const { return 1; }

  // Prepares the calling thread, before its first other call in a search. Sets its floating-point mode to the
  // default, as in another one (denormals flushed) results are other bits.
  virtual void attach(std::size_t thread);

  // Forgets the previous search and takes the root's scenarios.
  virtual RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) = 0;

  // Queues leaves and returns how many it took; never blocks.
  virtual std::size_t submit(std::size_t thread, Span<const LeafRequest> requests) = 0;

  // Gives the thread's next finished leaf, in the order of its submission; false if it is not there yet.
  virtual bool poll(std::size_t thread, LeafResult& result) = 0;

  // Drops all leaves of the search, those in flight included.
  virtual void release() = 0;

  virtual EvaluatorStats stats() const { return {}; }

  // Why its device is lost; empty while it is not.
  virtual std::string problem() const { return {}; }

  // Whether its device does not answer any more, for which it waits as long as `patience`: to destroy it
  // would then never end. While no thread is in another call.
  virtual bool is_stuck() { return false; }
};

inline void LeafEvaluator::attach(std::size_t) { std::fesetenv(FE_DFL_ENV); }

}  // namespace hypgen
