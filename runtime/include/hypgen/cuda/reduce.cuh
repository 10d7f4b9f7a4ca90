// SPDX-License-Identifier: Apache-2.0
// Third kernel of a batch: outcomes of each action, grouped by observation, to child rows and an action row.
//
// Groups are numbered by their first member, so that no race can change the tree. Sums are integers.
#pragma once

#include "hypgen/cuda/batch.cuh"

namespace hypgen::cuda {

constexpr int kReduceBlock = kBlock;
constexpr std::uint32_t kEmpty = UINT32_MAX;

// Room to group `count` members by key, in shared memory where it fits.
struct GroupTable {
  std::uint32_t size;          // of the hash table, a power of two; one more slot is for terminal members
  std::uint32_t* firsts;       // [size + 1]: the smallest position with the slot's key
  std::uint32_t* counts;       // [size + 1]
  unsigned long long* uppers;  // [size + 1]
  unsigned long long* lowers;  // [size + 1]
  std::uint32_t* first_bits;   // a bit a position: it is the first of its group
  std::uint32_t* first_ranks;  // the bits set before each word of them

  __host__ __device__ static std::uint32_t size_for(std::uint32_t count) {
    std::uint32_t size = 2 * kWarp;
    while (size < 2 * count) size *= 2;
    return size;
  }
  __host__ __device__ static std::size_t bytes_for(std::uint32_t count) {
    const std::size_t slots = size_for(count) + 2;  // even, so that what follows is aligned
    return slots * 24 + (count / kWarp + 1) * 8;
  }
  __device__ GroupTable(unsigned char* memory, std::uint32_t capacity, std::uint32_t count) {
    const std::size_t slots = size_for(capacity) + 2;
    size = size_for(count);
    uppers = reinterpret_cast<unsigned long long*>(memory);
    lowers = uppers + slots;
    firsts = reinterpret_cast<std::uint32_t*>(lowers + slots);
    counts = firsts + slots;
    first_bits = counts + slots;
    first_ranks = first_bits + capacity / kWarp + 1;
  }
};

// What a warp knows of the groups among its lanes' members.
struct LaneGroups {
  unsigned peers;      // lanes of this lane's group
  bool leads;          // whether this lane is the first of them
  std::int64_t upper;  // sums, of lanes that lead
  std::int64_t lower;
};

template <class Key>
__device__ inline unsigned match_key(unsigned peers, const Key& key) {
  const auto* const words = reinterpret_cast<const unsigned long long*>(&key);
#pragma unroll
  for (std::size_t w = 0; w < kKeyWords<Key>; ++w) peers &= __match_any_sync(kAll, words[w]);
  return peers;
}

// The sum of `value` over the lanes of a warp for which `counts`, in limbs that cannot overflow a 32-bit sum.
__device__ inline std::int64_t sum_where(bool counts, std::int64_t value) {
  if (!counts) value = 0;
#if __CUDA_ARCH__ >= 800
  constexpr int kLimb = 24;
  constexpr std::int64_t kMask = (std::int64_t{1} << kLimb) - 1;
  const std::int64_t low = __reduce_add_sync(kAll, static_cast<unsigned>(value & kMask));
  const std::int64_t middle = __reduce_add_sync(kAll, static_cast<unsigned>(value >> kLimb & kMask));
  const std::int64_t high = __reduce_add_sync(kAll, static_cast<int>(value >> 2 * kLimb));
  return low + (middle << kLimb) + (high << 2 * kLimb);
#else
  for (unsigned offset = kWarp / 2; offset > 0; offset /= 2) value += __shfl_xor_sync(kAll, value, offset);
  return value;
#endif
}

// Groups the lanes of a warp whose `tag` (tile, terminal, absent) and key are equal. `shared` has room for
// two numbers a lane.
template <class Key>
__device__ LaneGroups group_lanes(unsigned tag, const Key& key, std::int64_t upper, std::int64_t lower,
                                  std::int64_t* shared) {
  constexpr int kFewGroups = 2;  // then it is faster to add up group after group than lane after lane
  const unsigned lane = threadIdx.x % kWarp;
  LaneGroups groups{};
  groups.peers = match_key(__match_any_sync(kAll, tag), key);
  groups.leads = __ffs(groups.peers) - 1 == static_cast<int>(lane);
  unsigned leaders = __ballot_sync(kAll, groups.leads);
  if (__popc(leaders) <= kFewGroups) {
    for (; leaders != 0; leaders &= leaders - 1) {
      const int leader = __ffs(leaders) - 1;
      const bool counts = __shfl_sync(kAll, groups.peers, leader) >> lane & 1;
      const std::int64_t uppers = sum_where(counts, upper), lowers = sum_where(counts, lower);
      if (static_cast<int>(lane) == leader) groups.upper = uppers, groups.lower = lowers;
    }
    return groups;
  }
  shared[2 * lane] = upper;
  shared[2 * lane + 1] = lower;
  __syncwarp();
  if (groups.leads) {
    for (unsigned rest = groups.peers; rest != 0; rest &= rest - 1) {
      const int other = __ffs(rest) - 1;
      groups.upper += shared[2 * other];
      groups.lower += shared[2 * other + 1];
    }
  }
  __syncwarp();
  return groups;
}

__device__ inline std::int64_t sum_lanes(std::int64_t value, unsigned width) {
  for (unsigned offset = width / 2; offset > 0; offset /= 2) value += __shfl_xor_sync(kAll, value, offset);
  return value;
}

// The smallest power of two that `count` members fit into.
__device__ inline unsigned tile_for(std::uint32_t count) {
  unsigned tile = 1;
  while (tile < count) tile *= 2;
  return tile;
}

// Actions that a warp reduces at once, for a leaf of at most kWarp members.
__device__ inline std::uint32_t actions_a_warp(std::uint32_t count) { return kWarp / tile_for(count); }

// Blocks' worth of work in a leaf.
template <class M>
__device__ inline std::uint32_t units_of(const Batch<M>& batch, int leaf) {
  const std::uint32_t actions = batch.legal_count[leaf], count = batch.tasks[leaf].count;
  const std::uint32_t a_block = (count > kWarp ? 1 : actions_a_warp(count)) * (kReduceBlock / kWarp);
  return (actions + a_block - 1) / a_block;
}

// A tile of lanes an action.
template <class M>
__device__ void reduce_small(const Batch<M>& batch, int leaf, std::uint32_t first_item, std::uint32_t unit,
                             std::int64_t* shared) {
  const std::uint32_t count = batch.tasks[leaf].count, actions = batch.legal_count[leaf];
  const unsigned lane = threadIdx.x % kWarp, warp = threadIdx.x / kWarp;
  const unsigned tile = tile_for(count), tiles = kWarp / tile;
  const std::uint32_t a = (unit * (kReduceBlock / kWarp) + warp) * tiles + lane / tile;
  const std::uint32_t i = lane % tile;
  const bool present = a < actions && i < count;
  const std::uint32_t item = first_item + a * count + i;
  const bool terminal = present && batch.terminals[item] != 0;
  typename M::Key key{};
  std::int64_t reward = 0, upper = 0, lower = 0;
  if (present) {
    key = batch.keys[item];
    reward = batch.rewards[item];
    upper = batch.uppers[item];
    lower = batch.lowers[item];
  }
  const unsigned tag = lane / tile << 2 | (terminal ? 2U : 0U) | (present ? 1U : 0U);
  const LaneGroups groups = group_lanes(tag, key, upper, lower, shared + 2 * kWarp * warp);
  const bool leads = present && groups.leads;
  const unsigned tile_lanes = (tile == kWarp ? kAll : (1U << tile) - 1) << (lane / tile * tile);
  const unsigned leaders = __ballot_sync(kAll, leads) & tile_lanes;
  if (leads) {
    ChildRow row = empty_row(i, static_cast<std::uint32_t>(__popc(groups.peers)), terminal);
    row.upper_sum = groups.upper;
    row.lower_sum = groups.lower;
    batch.child_rows[first_item + a * count + __popc(leaders & ((1U << lane) - 1))] = row;
  }
  const std::int64_t rewards = sum_lanes(reward, tile);
  const std::int64_t uppers = sum_lanes(leads ? max(groups.upper, groups.lower) : 0, tile);
  const std::int64_t lowers = sum_lanes(leads ? groups.lower : 0, tile);
  if (present && i == 0) {
    const std::size_t at = std::size_t(leaf) * batch.max_actions + a;
    ActionRow row{};
    row.reward_sum = rewards;
    row.upper_sum = uppers;
    row.lower_sum = lowers;
    row.action = batch.legal[at];
    row.child_count = static_cast<std::uint32_t>(__popc(leaders));
    batch.action_rows[at] = row;
  }
}

// A group of an action, held by one lane of the warp that reduces it.
template <class Key>
struct HeldGroup {
  Key key;
  bool terminal;
  std::uint32_t first;
  std::uint32_t count;
  std::int64_t upper;
  std::int64_t lower;
};

template <class Key>
__device__ inline Key key_of_lane(const Key& key, int lane) {
  Key result;
  const auto* const from = reinterpret_cast<const unsigned long long*>(&key);
  auto* const to = reinterpret_cast<unsigned long long*>(&result);
#pragma unroll
  for (std::size_t w = 0; w < kKeyWords<Key>; ++w) to[w] = __shfl_sync(kAll, from[w], lane);
  return result;
}

// A warp an action, its groups in registers: lane g holds group g. False if there are more groups than lanes;
// nothing is written then.
template <class M>
__device__ bool reduce_warp(const Batch<M>& batch, int leaf, std::uint32_t first_item, std::uint32_t a,
                            std::int64_t* shared) {
  const std::uint32_t count = batch.tasks[leaf].count, items = first_item + a * count;
  const int lane = static_cast<int>(threadIdx.x % kWarp);
  HeldGroup<typename M::Key> held{};
  int groups = 0;
  std::int64_t reward = 0;
  for (std::uint32_t start = 0; start < count; start += kWarp) {
    const std::uint32_t i = start + static_cast<std::uint32_t>(lane);
    const bool present = i < count;
    const bool terminal = present && batch.terminals[items + i] != 0;
    typename M::Key key{};
    std::int64_t upper = 0, lower = 0;
    if (present) {
      key = batch.keys[items + i];
      reward += batch.rewards[items + i];
      upper = batch.uppers[items + i];
      lower = batch.lowers[items + i];
    }
    const unsigned tag = (terminal ? 2U : 0U) | (present ? 1U : 0U);
    const LaneGroups found = group_lanes(tag, key, upper, lower, shared);
    for (unsigned leaders = __ballot_sync(kAll, present && found.leads); leaders != 0;
         leaders &= leaders - 1) {
      const int leader = __ffs(leaders) - 1;
      const typename M::Key wanted = key_of_lane(key, leader);
      const bool ends = __shfl_sync(kAll, terminal, leader);
      const unsigned holds =
          __ballot_sync(kAll, lane < groups && held.terminal == ends && (ends || held.key == wanted));
      const int group = holds != 0 ? __ffs(holds) - 1 : groups++;
      if (group == kWarp) return false;
      const std::int64_t uppers = __shfl_sync(kAll, found.upper, leader);
      const std::int64_t lowers = __shfl_sync(kAll, found.lower, leader);
      const std::uint32_t members = __popc(__shfl_sync(kAll, found.peers, leader));
      if (lane == group) {
        if (holds == 0) {
          held = {};
          held.key = wanted;
          held.terminal = ends;
          held.first = start + static_cast<std::uint32_t>(leader);
        }
        held.count += members;
        held.upper += uppers;
        held.lower += lowers;
      }
    }
  }
  const bool holds = lane < groups;
  if (holds) {
    ChildRow row = empty_row(held.first, held.count, held.terminal);
    row.upper_sum = held.upper;
    row.lower_sum = held.lower;
    batch.child_rows[items + static_cast<std::uint32_t>(lane)] = row;
  }
  const std::int64_t rewards = sum_lanes(reward, kWarp);
  const std::int64_t uppers = sum_lanes(holds ? max(held.upper, held.lower) : 0, kWarp);
  const std::int64_t lowers = sum_lanes(holds ? held.lower : 0, kWarp);
  if (lane == 0) {
    const std::size_t at = std::size_t(leaf) * batch.max_actions + a;
    ActionRow row{};
    row.reward_sum = rewards;
    row.upper_sum = uppers;
    row.lower_sum = lowers;
    row.action = batch.legal[at];
    row.child_count = static_cast<std::uint32_t>(groups);
    batch.action_rows[at] = row;
  }
  return true;
}

// The slot of a key that is in the table, or a new one for it: position `i` claims it.
template <class M>
__device__ std::uint32_t find_slot(const Batch<M>& batch, const GroupTable& table, std::uint32_t first_item,
                                   std::uint32_t i, const typename M::Key& key) {
  std::uint32_t slot = static_cast<std::uint32_t>(key_hash(key) >> 32) & (table.size - 1);
  while (true) {
    const std::uint32_t holder = atomicCAS(&table.firsts[slot], kEmpty, i);
    if (holder == kEmpty || batch.keys[first_item + holder] == key) return slot;
    slot = (slot + 1) & (table.size - 1);
  }
}

// A block an action: its groups in a hash table.
template <class M>
__device__ void reduce_large(const Batch<M>& batch, int leaf, std::uint32_t first_item, std::uint32_t a,
                             const GroupTable& table, std::int64_t* shared) {
  __shared__ std::int64_t sums[3];
  __shared__ std::uint32_t warp_sums[kReduceBlock / kWarp];
  const std::uint32_t count = batch.tasks[leaf].count;
  const unsigned lane = threadIdx.x % kWarp, warp = threadIdx.x / kWarp;
  const std::uint32_t items = first_item + a * count;
  const std::uint32_t bit_words = count / kWarp + 1;
  if (threadIdx.x < 3) sums[threadIdx.x] = 0;
  for (std::uint32_t s = threadIdx.x; s <= table.size; s += blockDim.x) {
    table.firsts[s] = kEmpty;
    table.counts[s] = 0;
    table.uppers[s] = table.lowers[s] = 0;
  }
  for (std::uint32_t w = threadIdx.x; w < bit_words; w += blockDim.x) table.first_bits[w] = 0;
  __syncthreads();
  std::int64_t reward = 0;
  for (std::uint32_t start = 0; start < count; start += blockDim.x) {
    const std::uint32_t i = start + threadIdx.x;
    const bool present = i < count;
    const bool terminal = present && batch.terminals[items + i] != 0;
    typename M::Key key{};
    std::int64_t upper = 0, lower = 0;
    if (present) {
      key = batch.keys[items + i];
      reward += batch.rewards[items + i];
      upper = batch.uppers[items + i];
      lower = batch.lowers[items + i];
    }
    const unsigned tag = (terminal ? 2U : 0U) | (present ? 1U : 0U);
    const LaneGroups groups = group_lanes(tag, key, upper, lower, shared + 2 * kWarp * warp);
    if (present && groups.leads) {
      const std::uint32_t slot = terminal ? table.size : find_slot(batch, table, items, i, key);
      atomicMin(&table.firsts[slot], i);
      atomicAdd(&table.counts[slot], __popc(groups.peers));
      atomicAdd(&table.uppers[slot], static_cast<unsigned long long>(groups.upper));
      atomicAdd(&table.lowers[slot], static_cast<unsigned long long>(groups.lower));
    }
  }
  __syncthreads();
  std::int64_t uppers = 0, lowers = 0;
  for (std::uint32_t s = threadIdx.x; s <= table.size; s += blockDim.x) {
    const std::uint32_t first = table.firsts[s];
    if (first == kEmpty) continue;
    atomicOr(&table.first_bits[first / kWarp], 1U << first % kWarp);
    uppers += max(static_cast<std::int64_t>(table.uppers[s]), static_cast<std::int64_t>(table.lowers[s]));
    lowers += static_cast<std::int64_t>(table.lowers[s]);
  }
  reward = sum_lanes(reward, kWarp);
  uppers = sum_lanes(uppers, kWarp);
  lowers = sum_lanes(lowers, kWarp);
  if (lane == 0) {
    atomicAdd(reinterpret_cast<unsigned long long*>(&sums[0]), static_cast<unsigned long long>(reward));
    atomicAdd(reinterpret_cast<unsigned long long*>(&sums[1]), static_cast<unsigned long long>(uppers));
    atomicAdd(reinterpret_cast<unsigned long long*>(&sums[2]), static_cast<unsigned long long>(lowers));
  }
  __syncthreads();
  std::uint32_t groups = 0;
  for (std::uint32_t start = 0; start < bit_words; start += blockDim.x) {
    const std::uint32_t w = start + threadIdx.x;
    std::uint32_t total = 0;
    const std::uint32_t before =
        scan_in_block(w < bit_words ? __popc(table.first_bits[w]) : 0, warp_sums, total);
    if (w < bit_words) table.first_ranks[w] = groups + before;
    groups += total;
  }
  __syncthreads();
  for (std::uint32_t s = threadIdx.x; s <= table.size; s += blockDim.x) {
    const std::uint32_t first = table.firsts[s];
    if (first == kEmpty) continue;
    const unsigned below = table.first_bits[first / kWarp] & ((1U << first % kWarp) - 1);
    ChildRow row = empty_row(first, table.counts[s], s == table.size);
    row.upper_sum = static_cast<std::int64_t>(table.uppers[s]);
    row.lower_sum = static_cast<std::int64_t>(table.lowers[s]);
    batch.child_rows[items + table.first_ranks[first / kWarp] + __popc(below)] = row;
  }
  if (threadIdx.x == 0) {
    const std::size_t at = std::size_t(leaf) * batch.max_actions + a;
    ActionRow row{};
    row.reward_sum = sums[0];
    row.upper_sum = sums[1];
    row.lower_sum = sums[2];
    row.action = batch.legal[at];
    row.child_count = groups;
    batch.action_rows[at] = row;
  }
  __syncthreads();
}

// A warp an action; those with many groups are then taken by the whole block, one after the other.
template <class M>
__device__ void reduce_many(const Batch<M>& batch, int leaf, std::uint32_t first_item, std::uint32_t unit,
                            const GroupTable& table, std::int64_t* shared) {
  constexpr std::uint32_t kWarps = kReduceBlock / kWarp;
  __shared__ bool left[kWarps];
  const std::uint32_t warp = threadIdx.x / kWarp, actions = batch.legal_count[leaf];
  const std::uint32_t a = unit * kWarps + warp;
  const bool done = a >= actions || reduce_warp(batch, leaf, first_item, a, shared + 2 * kWarp * warp);
  if (threadIdx.x % kWarp == 0) left[warp] = !done;
  __syncthreads();
  for (std::uint32_t w = 0; w < kWarps; ++w) {
    if (left[w]) reduce_large(batch, leaf, first_item, unit * kWarps + w, table, shared);
  }
  __syncthreads();
}

// `tables` is room for a table a block in device memory, or null where shared memory has it.
template <class M>
__global__ void __launch_bounds__(kReduceBlock)
    reduce(const __grid_constant__ Batch<M> batch, unsigned char* tables, std::uint32_t capacity,
           std::size_t table_stride) {
  extern __shared__ __align__(16) unsigned char table_memory[];
  __shared__ LeafOffsets items, units;
  __shared__ std::int64_t shared[2 * kReduceBlock];
  items.fill(batch.leaves, [&](int leaf) { return items_of(batch, leaf); });
  units.fill(batch.leaves, [&](int leaf) { return units_of(batch, leaf); });
  unsigned char* const memory = tables == nullptr ? table_memory : tables + blockIdx.x * table_stride;
  for (std::uint32_t unit = blockIdx.x; unit < units.starts[batch.leaves]; unit += gridDim.x) {
    const int leaf = units.leaf_of(unit, batch.leaves);
    const std::uint32_t within = unit - units.starts[leaf];
    const std::uint32_t count = batch.tasks[leaf].count;
    if (count <= kWarp) {
      reduce_small(batch, leaf, items.starts[leaf], within, shared);
    } else {
      reduce_many(batch, leaf, items.starts[leaf], within, GroupTable(memory, capacity, count), shared);
    }
  }
}

}  // namespace hypgen::cuda
