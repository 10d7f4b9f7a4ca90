// SPDX-License-Identifier: Apache-2.0
// The data that the kernels of a batch share: leaves, addresses of their data, and numbers of their items.
#pragma once

#include <cstddef>
#include <cstdint>

#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/leaves/rolled_actions.hpp"
#include "hypgen/leaves/scenario_shares.hpp"
#include "hypgen/model/key.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen::cuda {

constexpr int kMaxLeaves = 256;  // of a batch
constexpr int kBlock = 256;      // threads of a block that works on one leaf
constexpr int kWarp = 32;
constexpr int kMostBlockWarps = 1024 / kWarp;  // that a device runs
constexpr unsigned kAll = 0xFFFFFFFFU;
constexpr std::int32_t kNoStep = -1;  // in place of an action: bounds of the members as they are
constexpr std::uint32_t kNoParent = UINT32_MAX;
constexpr std::uint32_t kAllLegal = UINT32_MAX;  // in place of where a list of actions starts

// A leaf, written by the host.
struct LeafTask {
  std::uint32_t node;    // its own number
  std::uint32_t parent;  // kNoParent: its members are there already
  std::uint32_t base;    // of its members in the arena
  std::uint32_t count;   // of members
  std::uint32_t mass;    // in a weighted search: what they count for, in units of kScenarioMass
  std::uint32_t parent_base;
  std::uint32_t parent_count;
  std::uint32_t first;  // position in the parent
  std::int32_t action;  // that led to it
  std::int32_t depth;
  std::int32_t baseline;  // at the root: the default action, which gains are measured against; or -1
  std::uint32_t wanted;   // where its list of actions starts, or kAllLegal
  std::uint32_t wanted_count;
  std::uint32_t rolled;    // how many actions are rolled out besides the default policy's, or kRollsAll
  std::int64_t lower_sum;  // what is known of the leaf: an action that promises no more is not rolled out
};

// What the kernels find out about a leaf besides rows, written for the host by the last one.
struct LeafOutcome {
  std::uint32_t action_count;
  std::uint32_t first_line;  // of its rows, in the arena
  std::uint32_t child_count;
  std::uint32_t flags;
};

// The unit of the arena of rows, in pinned memory of the host: what a write across the bus should fill.
struct alignas(128) RowLine {
  unsigned char bytes[128];
};

// How a leaf's rows lie in its run of lines: actions at its start, then gains at the root, then children.
// Each kind starts a line.
struct RowLayout {
  std::uint32_t gains;
  std::uint32_t children;
  std::uint32_t end;

  __host__ __device__ RowLayout(std::uint32_t action_count, bool has_gains, std::uint32_t child_count)
      : gains(lines_for(action_count * sizeof(ActionRow))),
        children(gains + (has_gains ? lines_for(action_count * sizeof(Gain)) : 0)),
        end(children + lines_for(child_count * sizeof(ChildRow))) {}

 private:
  __host__ __device__ static std::uint32_t lines_for(std::size_t bytes) {
    return static_cast<std::uint32_t>((bytes + sizeof(RowLine) - 1) / sizeof(RowLine));
  }
};

enum LeafFlag : std::uint32_t {
  kNanFlag = 1,      // a bound or reward of the model was NaN
  kMembersFlag = 2,  // the parent's members gave other numbers than the child row said
  kFullFlag = 4,     // no room for the rows
};

// The passes of a batch over its leaves' actions and members. A rollout costs far more than a step, so the
// first pass steps all actions, and the second rolls out those that `choose_rolled` has taken.
// In a weighted search `kWeighted` stands for the second pass: what a member is worth depends on its group.
enum class Pass { kFirstSteps, kRollouts, kWeighted };

// Whether the second pass is needed: where a state's lower bound takes a rollout.
template <class M>
constexpr bool kHasRollouts = !M::kHasLower;

// What stays the same for all batches of a search.
struct SearchConstants {
  StreamKey key;
  std::uint32_t first_scenario;
  int depth_limit;
  bool at_horizon;
  bool weighted;
  double discount;
};

// What a weighted search knows of members after an action. By member, and where that is said by member and group.
template <class M>
struct WeighedItems {
  static constexpr std::size_t kNumbers = 6;  // of a member
  static constexpr std::size_t kShared = ScenarioShares<M>::kMostShared;

  // Of device memory, for a member.
  static constexpr std::size_t kBytes =
      sizeof(typename M::State) * (kKeyHoldsState<M> ? 1 + kShared : 1) + sizeof(std::uint64_t) +
      kShared * (sizeof(double) + sizeof(std::uint32_t)) + kNumbers * sizeof(std::uint32_t);

  typename M::State* nexts;
  typename M::State* group_nexts;  // by member and group; unused unless the key holds state
  double* posteriors;              // by member and group
  std::uint32_t* shares;           // by member and group
  std::uint64_t* sums;
  std::uint32_t* numbers;  // kNumbers for each
};

// A member's bounds in a group that sees another state than its own.
struct GroupBounds {
  std::int64_t upper;
  std::int64_t lower;
  bool is_other;  // false: the bounds are those of its own state
};

// A member in a group that sees another state than its own, which is rolled out.
struct Extra {
  std::uint32_t item;
  std::uint32_t group;
};

// All that the kernels of a batch read and write. Device memory but for what is marked.
template <class M>
struct Batch {
  SearchConstants search;
  int leaves;
  int max_actions;  // a leaf's list of actions has room for so many
  const typename M::Params* params;
  const float* discounts;
  const float* floors;             // of states at the horizon, by steps that are left
  const typename M::Fixed* fixed;  // by scenario
  std::uint32_t* members;          // word-major within a node: scenarios, then each word of the states
  typename M::History* histories;  // by node
  const LeafTask* tasks;
  const std::int32_t* wanted;
  std::int32_t* legal;          // [leaf][max_actions]
  std::uint32_t* legal_count;   // by leaf; a baseline is in the list but not counted
  std::uint32_t* flags;         // by leaf
  std::uint32_t* rolled;        // [leaf][max_actions]: places in `legal` of the actions that are rolled out
  std::uint32_t* rolled_count;  // by leaf
  double* promises;             // [leaf][max_actions]
  std::uint32_t* next_item;     // how many items have been taken, by pass
  std::uint32_t* leaves_done;
  unsigned long long* steps;  // simulated, of all batches

  // By item: (leaf, action, member) in that order, without gaps.
  typename M::Key* keys;
  std::int64_t* rewards;
  std::int64_t* uppers;
  std::int64_t* lowers;
  std::uint8_t* terminals;
  ChildRow* child_rows;    // of an action at its first item
  ActionRow* action_rows;  // [leaf][max_actions]

  // Of a weighted search.
  WeighedItems<M> parents;  // members of the leaves' parents after the action that led to each leaf
  typename M::Key* parent_keys;
  std::uint8_t* parent_terminals;
  WeighedItems<M> items;
  std::uint32_t* seen_by;     // by item: the member that sees what the item's likeliest group sees
  std::uint64_t* group_sums;  // by item: shares of an action's groups
  GroupBounds* group_bounds;  // by item and group; unused unless the key holds state
  Extra* extras;              // the same
  std::uint32_t* extra_count;
  ScenarioShares<M>* action_shares;  // [leaf][max_actions]

  std::uint32_t* arena_used;  // lines that this search has taken
  std::uint32_t arena_size;

  // Pinned memory of the host.
  RowLine* arena;  // rows stay there as long as the search
  LeafOutcome* outcomes;
  volatile unsigned long long* out_steps;
  volatile std::uint32_t* done;  // becomes `number` when all of the above is written
  std::uint32_t number;
};

template <class M>
constexpr std::uint32_t kStateWords = sizeof(typename M::State) / sizeof(std::uint32_t);
template <class M>
constexpr std::uint32_t kMemberWords = 1 + kStateWords<M>;

// Words `i`, `i + count`, ... of a node's block.
template <class M>
__device__ inline typename M::State load_state(const std::uint32_t* block, std::uint32_t count,
                                               std::uint32_t i) {
  typename M::State state;
#pragma unroll
  for (std::uint32_t w = 0; w < kStateWords<M>; ++w) {
    reinterpret_cast<std::uint32_t*>(&state)[w] = block[(1 + w) * count + i];
  }
  return state;
}

template <class M>
__device__ inline void store_member(std::uint32_t* block, std::uint32_t count, std::uint32_t i,
                                    std::uint32_t scenario, const typename M::State& state) {
  block[i] = scenario;
#pragma unroll
  for (std::uint32_t w = 0; w < kStateWords<M>; ++w) {
    block[(1 + w) * count + i] = reinterpret_cast<const std::uint32_t*>(&state)[w];
  }
}

// A node's block of members.
template <class M>
__device__ inline std::uint32_t* block_of(std::uint32_t* members, std::uint32_t base) {
  return members + std::size_t{base} * kMemberWords<M>;
}

// The number of threads before this one in the block for which `holds`, and of all of them in `total`.
__device__ inline std::uint32_t rank_in_block(bool holds, std::uint32_t* warp_counts, std::uint32_t& total) {
  const unsigned lane = threadIdx.x % kWarp, warp = threadIdx.x / kWarp;
  const unsigned votes = __ballot_sync(kAll, holds);
  if (lane == 0) warp_counts[warp] = __popc(votes);
  __syncthreads();
  std::uint32_t before = 0;
  total = 0;
  for (unsigned w = 0; w < blockDim.x / kWarp; ++w) {
    before += w < warp ? warp_counts[w] : 0;
    total += warp_counts[w];
  }
  __syncthreads();
  return before + __popc(votes & ((1U << lane) - 1));
}

// The exclusive sums of `value` over the block's threads, and the sum of all in `total`.
__device__ inline std::uint32_t scan_in_block(std::uint32_t value, std::uint32_t* warp_sums,
                                              std::uint32_t& total) {
  const unsigned lane = threadIdx.x % kWarp, warp = threadIdx.x / kWarp;
  std::uint32_t sum = value;
  for (unsigned offset = 1; offset < kWarp; offset *= 2) {
    const std::uint32_t other = __shfl_up_sync(kAll, sum, offset);
    if (lane >= offset) sum += other;
  }
  if (lane == kWarp - 1) warp_sums[warp] = sum;
  __syncthreads();
  std::uint32_t before = 0;
  total = 0;
  for (unsigned w = 0; w < blockDim.x / kWarp; ++w) {
    before += w < warp ? warp_sums[w] : 0;
    total += warp_sums[w];
  }
  __syncthreads();
  return before + sum - value;
}

// Running totals over a batch's leaves, so that one number names a piece of work of any leaf. Every block
// makes its own copy: a scan of at most kMaxLeaves numbers, which may be more than it has threads.
struct LeafOffsets {
  std::uint32_t starts[kMaxLeaves + 1];
  std::uint32_t warp_sums[kMostBlockWarps];

  // `amount(leaf)` is the leaf's work. For all threads of a block, of any number of warps.
  template <class Amount>
  __device__ void fill(int leaves, const Amount& amount) {
    std::uint32_t before = 0;
    for (int first = 0; first < leaves; first += static_cast<int>(blockDim.x)) {
      const int leaf = first + static_cast<int>(threadIdx.x);
      std::uint32_t total = 0;
      const std::uint32_t start = scan_in_block(leaf < leaves ? amount(leaf) : 0, warp_sums, total);
      if (leaf < leaves) starts[leaf] = before + start;
      before += total;
    }
    if (threadIdx.x == 0) starts[leaves] = before;
    __syncthreads();
  }

  // The leaf that `at` belongs to: the last that starts at or before it and is not empty.
  __device__ int leaf_of(std::uint32_t at, int leaves) const {
    int low = 0, high = leaves;
    while (high - low > 1) {
      const int middle = (low + high) / 2;
      if (starts[middle] <= at) {
        low = middle;
      } else {
        high = middle;
      }
    }
    return low;
  }
};

// How many items a leaf has: its actions, a baseline included, times its members.
template <class M>
__device__ inline std::uint32_t items_of(const Batch<M>& batch, int leaf) {
  const LeafTask& task = batch.tasks[leaf];
  return (batch.legal_count[leaf] + (task.baseline >= 0 ? 1 : 0)) * task.count;
}

// How many items of a leaf are rolled out: its rolled-out actions times its members.
template <class M>
__device__ inline std::uint32_t rolled_items_of(const Batch<M>& batch, int leaf) {
  return batch.rolled_count[leaf] * batch.tasks[leaf].count;
}

}  // namespace hypgen::cuda
