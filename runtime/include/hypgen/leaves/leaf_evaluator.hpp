// SPDX-License-Identifier: Apache-2.0
// The interface between the search, which knows no model, and an evaluator, which simulates the model.
#pragma once

#include <cfenv>
#include <cstddef>
#include <cstdint>
#include <string>

#include "hypgen/core/deadline.hpp"
#include "hypgen/core/span.hpp"
#include "hypgen/core/status.hpp"
#include "hypgen/memory/scenario_buffer.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen_lanes {
struct Kernel;
}

namespace hypgen {

// The options of an evaluator.
struct EvaluatorOptions {
  std::size_t max_scenarios = 500;
  std::size_t memory_bytes = std::size_t{256} << 20;  // for the states and rows of expanded nodes
  double discount = 0.95;
  int max_depth = 90;
  std::size_t in_flight = 1;                    // leaves that all threads of the search keep submitted
  std::size_t device_memory_bytes = 0;          // of a GPU; 0: half of what is free, at most 8 GB
  int warps = 0;                                // of a GPU that share a step; 0: each batch chooses
  std::size_t threads = 1;                      // of the search
  bool may_weigh = false;                       // some search may be weighted
  const hypgen_lanes::Kernel* lanes = nullptr;  // what the host rolls out by; null: one rollout at a time
  bool measures_lanes = true;  // what is slower is left out; false, for checks: all rollouts go by lanes
  double patience = 10.0;      // seconds without an answer after which a device is lost
};

// The settings of one search.
struct SearchSetup {
  StreamKey key{};
  int depth_limit = 0;      // at most the options' max_depth
  bool at_horizon = false;  // the episode ends at that depth, and states there are worth nothing
  Deadline deadline{};
  bool weighted = false;  // groups share scenarios, with weights; counts are in units of kScenarioMass
};

constexpr std::uint64_t kNoHandle = UINT64_MAX;

// A node to expand: the root (parent kNoHandle), or a group of an action of an expanded parent. The group's
// first member names it. The terminal group is never expanded.
struct LeafRequest {
  std::uint32_t ticket = 0;
  std::uint64_t parent = kNoHandle;
  int action = 0;
  std::uint32_t first = 0;  // ChildRow::first of the group
  std::uint32_t count = 0;  // its scenarios
  int depth = 0;
  // The actions to try, ascending; empty: all. The evaluator leaves out those that are not legal. The caller
  // keeps them until it has the result.
  Span<const int> actions{};
  // The evaluator rolls out so many actions besides the default policy's: those that promise most
  // (rolled_actions.hpp). UINT32_MAX: all, and at the root gains too.
  std::uint32_t rolled = UINT32_MAX;
  // A known lower bound of the leaf. The evaluator does not roll out an action that promises no more.
  std::int64_t lower_sum = INT64_MIN;
};

// A group: the scenarios of a node that saw the same observation after an action. Groups stand in the order
// of their first members. Terminal scenarios form a group of their own. Sums are in fixed point, not
// discounted for the step to the child.
struct ChildRow {
  std::int64_t upper_sum;
  std::int64_t lower_sum;
  std::uint32_t first;  // the group's first scenario: a position among the parent's
  std::uint32_t count : 31;
  std::uint32_t terminal : 1;
};
static_assert(sizeof(ChildRow) == 24);

// A group's row with sums of 0.
constexpr ChildRow empty_row(std::uint32_t first, std::uint32_t count, bool terminal) {
  ChildRow row{};
  row.first = first;
  row.count = count & INT32_MAX;
  row.terminal = terminal;
  return row;
}

// An action at the leaf. Its bounds are the sums of its children's. A child's upper bound below its lower one
// counts as the lower one.
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

// The gain of an action at the root over the default policy's action: the difference of one-ply returns,
// summed over scenarios. A one-ply return is the reward plus the discounted lower bound.
struct Gain {
  std::int64_t sum;
  double square_sum;
};

// An expanded leaf, or the reason why there is none: without kOk there are no rows. Rows are valid until
// `release`.
struct LeafResult {
  std::uint32_t ticket = 0;
  Status status = Status::kOk;
  std::uint64_t handle = 0;
  std::uint32_t count = 0;  // the leaf's scenarios
  Span<const ActionRow> actions{};
  Span<const ChildRow> children{};
  Span<const Gain> gains{};  // one for each action of a root that rolls out all, none elsewhere
};

// Counts of an evaluator since it was made; 0 also where the evaluator does not count.
struct EvaluatorStats {
  std::uint64_t batches = 0;
  std::uint64_t leaves = 0;
  std::uint64_t host_leaves = 0;  // besides those of a device
  std::uint64_t steps = 0;        // simulated steps, rollouts included
  std::uint64_t bytes_read = 0;   // from a device
  double kernel_seconds = 0.0;    // summed over kernels
  double busy_seconds = 0.0;      // while at least one kernel ran

  void add(const EvaluatorStats& other) {
    batches += other.batches;
    leaves += other.leaves;
    host_leaves += other.host_leaves;
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

// Expands leaves for the threads of a search, which are numbered from 0. A thread calls `attach`, `submit`,
// `poll` and `expand_here` with its own number, at any time. It has leaves of its own in flight, below parents
// that any thread has expanded. All other calls come from one thread while no thread is in a call. Only the
// constructor allocates.
class LeafEvaluator {
 public:
  virtual ~LeafEvaluator() = default;

  // The number of threads that it serves: those of its options, or fewer if memory does not suffice.
  virtual std::size_t threads() const { return 1; }

  // The number of rollouts that take no longer than one: those that a device runs at once.
  virtual std::size_t lanes() const { return 1; }

  // Prepares the calling thread. A thread calls it first in each search. It sets the default floating-point
  // mode: in another mode, for example with denormals flushed, results have other bits.
  virtual void attach(std::size_t thread);

  // Forgets the previous search and takes the root's scenarios.
  virtual RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) = 0;

  // Queues leaves and returns how many it took; never blocks.
  virtual std::size_t submit(std::size_t thread, Span<const LeafRequest> requests) = 0;

  // Gives the thread's next leaf in the order of submission; false if it is not finished.
  virtual bool poll(std::size_t thread, LeafResult& result) = 0;

  // Expands a leaf below the root at once; false: submit it. The thread does so if that takes it less time than
  // its share of a device's answer. It has `at_once` leaves on the device at the same time.
  virtual bool expand_here(std::size_t thread, const LeafRequest& request, std::size_t at_once,
                           LeafResult& result);

  // Drops all leaves of the search, leaves in flight included.
  virtual void release() = 0;

  virtual EvaluatorStats stats() const { return {}; }

  // The reason why the device is lost; empty while it is not.
  virtual std::string problem() const { return {}; }

  // Whether the device has given no answer for `patience`. The destructor of such an evaluator would never
  // end.
  virtual bool is_stuck() { return false; }
};

inline void LeafEvaluator::attach(std::size_t) { std::fesetenv(FE_DFL_ENV); }

inline bool LeafEvaluator::expand_here(std::size_t, const LeafRequest&, std::size_t, LeafResult&) {
  return false;
}

}  // namespace hypgen
