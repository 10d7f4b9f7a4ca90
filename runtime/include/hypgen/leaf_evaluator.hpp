// The seam between the search, which knows no model, and what simulates the model.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "hypgen/philox.hpp"
#include "hypgen/scenario_buffer.hpp"
#include "hypgen/span.hpp"
#include "hypgen/status.hpp"

namespace hypgen {

using Clock = std::chrono::steady_clock;

// Fixed when an evaluator is made.
struct EvaluatorOptions {
  std::size_t max_scenarios = 500;
  std::size_t memory_bytes = std::size_t{256} << 20;  // for the states of expanded nodes
  double discount = 0.95;
  int max_depth = 90;
};

// What holds for one search.
struct SearchSetup {
  StreamKey key;
  int depth_limit;  // at most the options' max_depth
  bool at_horizon;  // the episode ends at that depth: nothing is earned from there on
  Clock::time_point deadline;
};

constexpr std::uint64_t kNoHandle = UINT64_MAX;

// A node to expand: the root (parent kNoHandle), or a group of an action of an expanded parent.
struct LeafRequest {
  std::uint32_t ticket;
  std::uint64_t parent;
  int action;
  std::uint32_t group;
  int depth;
  Span<const int> actions;  // those to try, ascending; empty: all legal ones. Legal ones count only
};

// A group of scenarios that saw the same observation after an action. Groups are numbered by first
// appearance; terminal scenarios are a group of their own. Sums are fixed point, of values as seen from the
// child.
struct ChildRow {
  std::uint32_t count;
  bool terminal;
  std::int64_t upper_sum;
  std::int64_t lower_sum;
};

// An action at the leaf. The gains, at the root only, are scenario-wise differences of the one-ply return
// (reward plus discounted lower bound) from the default policy's action.
struct ActionRow {
  int action;
  std::uint32_t count;
  std::int64_t reward_sum;
  std::uint32_t first_child;  // index into LeafResult::children
  std::uint32_t child_count;
  std::int64_t gain_sum;
  double gain_square_sum;
};

// An expanded leaf, or why it is not (`status` other than kOk: no rows). Valid until the next poll.
struct LeafResult {
  std::uint32_t ticket;
  Status status;
  std::uint64_t handle;
  Span<const ActionRow> actions;
  Span<const ChildRow> children;
};

// The root's bounds, and the default policy's action there (-1: no action is legal).
struct RootResult {
  Status status;
  ChildRow row;
  int default_action;
};

// Allocates only when it is made.
class LeafEvaluator {
 public:
  virtual ~LeafEvaluator() = default;

  // Forgets the previous search and takes the root's scenarios.
  virtual RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) = 0;

  // Queues leaves and returns how many it took; never blocks.
  virtual std::size_t submit(Span<const LeafRequest> requests) = 0;

  // Gives one finished leaf; false if none is ready.
  virtual bool poll(LeafResult& result) = 0;

  // Drops all leaves of the search, those in flight included.
  virtual void release() = 0;
};

}  // namespace hypgen
