// SPDX-License-Identifier: Apache-2.0
// The kernels of a weighted search: members by shares, the shares of each action, and rows by them.
//
// `ScenarioShares` is the text that the host runs too. A block evaluates the densities, which cost most; its first
// warp does the rest.
#pragma once

#include "hypgen/cuda/batch.cuh"
#include "hypgen/cuda/gather.cuh"
#include "hypgen/leaves/scenario_shares.hpp"
#include "hypgen/leaves/weighted_sums.hpp"
#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen::cuda {

constexpr int kWeighBlock = 128;  // threads of a block that works on one action

// A node's members after an action, each as if alone: where they are, what they see, and whether they ended.
template <class M>
struct SteppedMembers {
  const Batch<M>& batch;
  const std::uint32_t* block;
  std::uint32_t count;
  std::int32_t action;
  int depth;  // of the members
  typename M::State* nexts;
  typename M::Key* keys;
  std::uint8_t* terminals;

  __device__ const typename M::Fixed& fixed(std::uint32_t i) const { return batch.fixed[block[i]]; }
  __device__ typename M::State state(std::uint32_t i) const { return load_state<M>(block, count, i); }
  // A member draws under its place in the node.
  __device__ PhiloxDraws draws(std::uint32_t i) const {
    return PhiloxDraws(batch.search.key, batch.search.first_scenario + i, static_cast<std::uint32_t>(depth));
  }

  // Steps member i. Returns whether its numbers are broken.
  __device__ void step(std::uint32_t i) const {
    PhiloxDraws words = draws(i);
    const typename M::State from = state(i);
    const StepResult result = M::step(*batch.params, fixed(i), from, action, words, nexts[i]);
    terminals[i] = result.terminal;
    if (!result.terminal) keys[i] = M::observe(*batch.params, fixed(i), from, action, words, nexts[i]);
  }

  // How likely an observation is for member i. Where the key holds state, `next` becomes the state in which it sees it.
  __device__ double weigh(std::uint32_t i, const typename M::Key& key, typename M::State& next) const {
    PhiloxDraws words = draws(i);
    if constexpr (kKeyHoldsState<M>) {
      return M::filter(*batch.params, fixed(i), state(i), action, key, words, next);
    } else {
      return M::observation_density(*batch.params, fixed(i), state(i), action, key, words, nexts[i]);
    }
  }

  // The history after what member i sees.
  __device__ void see(std::uint32_t i, const typename M::History& before, typename M::History& after) const {
    M::advance_history(*batch.params, fixed(i), state(i), action, keys[i], nexts[i], before, after);
  }
};

// The threads of a warp as a team of `ScenarioShares`.
struct Warp {
  static constexpr std::uint32_t size = kWarp;

  __device__ std::uint32_t rank() const { return threadIdx.x % kWarp; }
  __device__ void wait() const { __syncwarp(); }
  template <class T>
  __device__ T sum(T value) const {
    for (unsigned offset = kWarp / 2; offset > 0; offset /= 2) value += __shfl_xor_sync(kAll, value, offset);
    return value;
  }
  __device__ WideSum sum(WideSum value) const {
    for (unsigned offset = kWarp / 2; offset > 0; offset /= 2) {
      const auto low = static_cast<std::uint64_t>(value), high = static_cast<std::uint64_t>(value >> 64);
      value += static_cast<WideSum>(__shfl_xor_sync(kAll, high, offset)) << 64 |
               __shfl_xor_sync(kAll, low, offset);
    }
    return value;
  }
  template <class T>
  __device__ T sum_up_to(T value) const {
    for (unsigned offset = 1; offset < kWarp; offset *= 2) {
      const T other = __shfl_up_sync(kAll, value, offset);
      if (rank() >= offset) value += other;
    }
    return value;
  }
  __device__ double largest(double value) const {
    for (unsigned offset = kWarp / 2; offset > 0; offset /= 2) {
      const double other = __shfl_xor_sync(kAll, value, offset);
      value = other > value ? other : value;
    }
    return value;
  }
  __device__ std::uint32_t least(std::uint32_t value) const {
    for (unsigned offset = kWarp / 2; offset > 0; offset /= 2)
      value = min(value, __shfl_xor_sync(kAll, value, offset));
    return value;
  }
};

// For a block: steps the members and parts them into groups. `shares` is in memory that the block shares.
template <class M>
__device__ void part(const SteppedMembers<M>& members, const SharesMemory<typename M::State>& memory,
                     ScenarioShares<M>& shares) {
  const bool is_first_warp = threadIdx.x < kWarp;
  const Warp warp;
  for (std::uint32_t i = threadIdx.x; i < members.count; i += blockDim.x) members.step(i);
  if (threadIdx.x == 0) shares.begin(memory, members.count);
  __syncthreads();
  if (is_first_warp) {
    std::uint32_t live = 0;
    for (std::uint32_t first = 0; first < members.count; first += kWarp) {
      const std::uint32_t i = first + warp.rank();
      const std::uint32_t own = i < members.count && members.terminals[i] == 0 ? 1 : 0;
      const std::uint32_t n = live + warp.sum_up_to(own) - own;
      if (own != 0) shares.enter_alone(i, n);
      live += warp.sum(own);
    }
    if (threadIdx.x == 0) shares.end_entering(live);
  }
  __syncthreads();
  const std::uint32_t draws = shares.draws(), classes = shares.classes();
  typename M::State unused;
  for (std::uint32_t at = threadIdx.x; at < draws * classes; at += blockDim.x) {
    const std::uint32_t n = at / classes, c = at % classes;
    typename M::State& next = kKeyHoldsState<M> ? shares.next_seen(n, c) : unused;
    shares.weight(n, c) = members.weigh(shares.scenario_of(c), members.keys[shares.drawn(n)], next);
  }
  __syncthreads();
  if (is_first_warp) {
    for (std::uint32_t n = 0; n < draws; ++n) shares.add(warp, n, shares.drawn(n));
    shares.share_out(warp);
    shares.group_the_rest(warp, [&](std::uint32_t i) {
      std::uint32_t known = 0;
      while (known < shares.rest() && !(members.keys[shares.first_of_rest(known)] == members.keys[i]))
        ++known;
      return known;
    });
  }
  __syncthreads();
}

// Members of several nodes after an action, one after the other: those of parents, or a batch's items.
template <class M>
__device__ SharesMemory<typename M::State> memory_at(const WeighedItems<M>& items, std::uint32_t first,
                                                     std::uint32_t count) {
  constexpr std::size_t kShared = ScenarioShares<M>::kMostShared;
  const std::size_t at = first;
  std::uint32_t* const numbers = items.numbers + at * WeighedItems<M>::kNumbers;
  return {kKeyHoldsState<M> ? items.group_nexts + at * kShared : nullptr,
          items.posteriors + at * kShared,
          items.shares + at * kShared,
          items.sums + at,
          numbers,
          numbers + count,
          numbers + 2 * count,
          numbers + 3 * count,
          numbers + 4 * count,
          numbers + 5 * count};
}

// First kernel of a batch: draws the leaf's members from those of its parent.
template <class M>
__device__ void draw_members(const Batch<M>& batch, int leaf, std::uint32_t first_item) {
  __shared__ ScenarioShares<M> shares;
  __shared__ std::uint32_t group;
  const LeafTask& task = batch.tasks[leaf];
  const WeighedItems<M>& room = batch.parents;
  const std::uint32_t* const parents = block_of<M>(batch.members, task.parent_base);
  const SteppedMembers<M> members{batch,
                                  parents,
                                  task.parent_count,
                                  task.action,
                                  task.depth - 1,
                                  room.nexts + first_item,
                                  batch.parent_keys + first_item,
                                  batch.parent_terminals + first_item};
  part(members, memory_at(room, first_item, task.parent_count), shares);
  std::uint32_t* const own = block_of<M>(batch.members, task.base);
  if (threadIdx.x == 0) {
    group = shares.named(task.first);
    if (group == shares.count()) atomicOr(&batch.flags[leaf], kMembersFlag);
  }
  __syncthreads();
  const bool is_known = group < shares.count();
  if (is_known && threadIdx.x < kWarp) {
    const std::uint32_t word =
        PhiloxDraws(batch.search.key, task.first, static_cast<std::uint32_t>(task.depth - 1))
            .word(kMembersSite, static_cast<std::uint32_t>(task.action));
    shares.draw(Warp(), group, task.count, word, [&](std::size_t i, std::uint32_t pick) { own[i] = pick; });
  }
  __syncthreads();
  for (std::uint32_t i = threadIdx.x; i < task.count; i += blockDim.x) {
    const std::uint32_t pick = is_known ? own[i] : 0;
    const typename M::State* const next = is_known ? shares.next(group, pick) : nullptr;
    store_member<M>(own, task.count, i, parents[pick], next != nullptr ? *next : members.nexts[pick]);
  }
  if (M::kHasHistory && threadIdx.x == 0 && is_known) {
    members.see(task.first, batch.histories[task.parent], batch.histories[task.node]);
  }
  __syncthreads();
}

template <class M>
__global__ void __launch_bounds__(kBlock) gather_weighted(const __grid_constant__ Batch<M> batch) {
  __shared__ LeafOffsets parents;
  parents.fill(batch.leaves, [&](int leaf) {
    return batch.tasks[leaf].parent == kNoParent ? 0 : batch.tasks[leaf].parent_count;
  });
  const int leaf = static_cast<int>(blockIdx.x);
  if (threadIdx.x == 0) {
    batch.flags[leaf] = 0;
    if (leaf == 0) batch.next_item[0] = batch.next_item[1] = *batch.leaves_done = *batch.extra_count = 0;
  }
  __syncthreads();
  if (batch.tasks[leaf].parent != kNoParent) draw_members(batch, leaf, parents.starts[leaf]);
  list_actions(batch, leaf);
}

template <class M>
__device__ SteppedMembers<M> stepped_items(const Batch<M>& batch, int leaf, std::uint32_t a,
                                           std::uint32_t first) {
  const LeafTask& task = batch.tasks[leaf];
  return {batch,
          block_of<M>(batch.members, task.base),
          task.count,
          batch.legal[std::size_t(leaf) * batch.max_actions + a],
          task.depth,
          batch.items.nexts + first,
          batch.keys + first,
          batch.terminals + first};
}

// Whether an action of a leaf is rolled out.
template <class M>
__device__ bool is_rolled(const Batch<M>& batch, int leaf, std::uint32_t a) {
  if (!kHasRollouts<M> || batch.tasks[leaf].rolled == kRollsAll) return true;
  const std::uint32_t* const rolled = batch.rolled + std::size_t(leaf) * batch.max_actions;
  for (std::uint32_t r = 0; r < batch.rolled_count[leaf]; ++r) {
    if (rolled[r] == a) return true;
  }
  return false;
}

// Bounds of a state that is not rolled out.
template <class M>
__device__ void bound_cheaply(const Batch<M>& batch, int leaf, const typename M::Fixed& fixed,
                              const typename M::State& state, int depth, std::int64_t& upper,
                              std::int64_t& lower) {
  const SearchConstants& search = batch.search;
  upper = lower = 0;
  if (search.at_horizon && depth >= search.depth_limit) return;
  const float most = M::upper(*batch.params, fixed, state);
  const float least =
      search.at_horizon ? batch.floors[search.depth_limit - depth] : M::tail(*batch.params, fixed, state);
  if (math::is_nan(most) || math::is_nan(least)) atomicOr(&batch.flags[leaf], kNanFlag);
  upper = math::to_fixed<kRewardBits<M>>(most);
  lower = min(upper, math::to_fixed<kRewardBits<M>>(least));
}

template <class T>
__device__ bool is_same(const T& a, const T& b) {
  const auto* const left = reinterpret_cast<const std::uint32_t*>(&a);
  const auto* const right = reinterpret_cast<const std::uint32_t*>(&b);
  for (std::size_t w = 0; w < sizeof(T) / sizeof(std::uint32_t); ++w) {
    if (left[w] != right[w]) return false;
  }
  return true;
}

// Bounds, or asks for those, of a member in groups that see another state than its own.
template <class M>
__device__ void bound_elsewhere(const Batch<M>& batch, int leaf, const SteppedMembers<M>& members,
                                const ScenarioShares<M>& shares, std::uint32_t first, std::uint32_t i,
                                bool rolls) {
  constexpr std::uint32_t kShared = ScenarioShares<M>::kMostShared;
  for (std::uint32_t g = 0; g < shares.shared(); ++g) {
    if (shares.share(g, i) == 0) continue;
    const typename M::State& next = *shares.next(g, i);
    const std::size_t at = (std::size_t{first} + i) * kShared + g;
    batch.group_bounds[at].is_other = !is_same(next, members.nexts[i]);
    if (!batch.group_bounds[at].is_other) continue;
    if (rolls) {
      batch.extras[atomicAdd(batch.extra_count, 1)] = {first + i, g};
    } else {
      bound_cheaply(batch, leaf, members.fixed(i), next, members.depth + 1, batch.group_bounds[at].upper,
                    batch.group_bounds[at].lower);
    }
  }
}

// Between the passes: parts the members of each action into groups. A block an action.
template <class M>
__global__ void __launch_bounds__(kWeighBlock) weigh(const __grid_constant__ Batch<M> batch) {
  __shared__ LeafOffsets items, actions;
  items.fill(batch.leaves, [&](int leaf) { return items_of(batch, leaf); });
  actions.fill(batch.leaves, [&](int leaf) { return batch.legal_count[leaf]; });
  for (std::uint32_t at = blockIdx.x; at < actions.starts[batch.leaves]; at += gridDim.x) {
    const int leaf = actions.leaf_of(at, batch.leaves);
    const std::uint32_t a = at - actions.starts[leaf], count = batch.tasks[leaf].count;
    const std::uint32_t first = items.starts[leaf] + a * count;
    const SteppedMembers<M> members = stepped_items(batch, leaf, a, first);
    ScenarioShares<M>& shares = batch.action_shares[std::size_t(leaf) * batch.max_actions + a];
    part(members, memory_at(batch.items, first, count), shares);
    const bool rolls = members.depth + 1 >= batch.search.depth_limit || is_rolled(batch, leaf, a);
    for (std::uint32_t i = threadIdx.x; i < count; i += blockDim.x) {
      if (members.terminals[i] != 0) continue;
      if constexpr (M::kHasHistory) batch.seen_by[first + i] = shares.first(shares.likeliest(i));
      if constexpr (kKeyHoldsState<M>) bound_elsewhere(batch, leaf, members, shares, first, i, rolls);
    }
  }
}

// Third kernel: rows of each action by shares. A warp an action.
template <class M>
__global__ void __launch_bounds__(kBlock) reduce_weighted(const __grid_constant__ Batch<M> batch) {
  constexpr std::size_t kShared = ScenarioShares<M>::kMostShared;
  __shared__ LeafOffsets items, actions;
  items.fill(batch.leaves, [&](int leaf) { return items_of(batch, leaf); });
  actions.fill(batch.leaves, [&](int leaf) { return batch.legal_count[leaf]; });
  const Warp warp;
  const unsigned lane = warp.rank();
  const std::uint32_t warps = gridDim.x * blockDim.x / kWarp;
  for (std::uint32_t at = (blockIdx.x * blockDim.x + threadIdx.x) / kWarp; at < actions.starts[batch.leaves];
       at += warps) {
    const int leaf = actions.leaf_of(at, batch.leaves);
    const LeafTask& task = batch.tasks[leaf];
    const std::uint32_t a = at - actions.starts[leaf], count = task.count;
    const std::uint32_t first = items.starts[leaf] + a * count;
    const std::size_t place = std::size_t(leaf) * batch.max_actions + a;
    const ScenarioShares<M>& shares = batch.action_shares[place];
    const std::uint64_t whole = std::uint64_t{count} * kWholeShare;
    if (shares.count() >
        count) {  // more than there is room for: a member that its own observation leaves out
      if (lane == 0) atomicOr(&batch.flags[leaf], kMembersFlag);
      continue;
    }
    // Of each group: its shares, and then its bounds. The shares up to a group give its mass.
    for (std::uint32_t g = 0; g < shares.count(); ++g) {
      std::uint64_t sum = 0;
      WideSum upper = 0, lower = 0;
      for (std::uint32_t i = lane; i < count; i += kWarp) {
        const std::uint32_t share = batch.terminals[first + i] != 0 ? 0 : shares.share(g, i);
        if (share == 0) continue;
        std::int64_t most = batch.uppers[first + i], least = batch.lowers[first + i];
        if constexpr (kKeyHoldsState<M>) {
          const auto& elsewhere = batch.group_bounds[(std::size_t{first} + i) * kShared + g];
          if (g < shares.shared() && elsewhere.is_other) most = elsewhere.upper, least = elsewhere.lower;
        }
        sum += share;
        upper += static_cast<WideSum>(most) * share;
        lower += static_cast<WideSum>(least) * share;
      }
      sum = warp.sum(sum);
      upper = warp.sum(upper);
      lower = warp.sum(lower);
      if (lane != 0) continue;
      ChildRow row = empty_row(shares.first(g), 0, false);
      row.upper_sum = spread(upper, task.mass, whole);
      row.lower_sum = spread(lower, task.mass, whole);
      batch.child_rows[first + g] = row;
      batch.group_sums[first + g] = sum;
    }
    WideSum rewards = 0;
    std::uint32_t ended = count;
    for (std::uint32_t i = lane; i < count; i += kWarp) {
      rewards += batch.rewards[first + i];
      if (batch.terminals[first + i] != 0 && ended == count) ended = i;
    }
    rewards = warp.sum(rewards);
    ended = warp.least(ended);
    if (lane == 0) {
      ActionRow row{};
      row.action = batch.legal[place];
      row.reward_sum = spread(rewards, task.mass, count);
      std::uint64_t reached = 0, before = 0;
      const auto mass_after = [&](std::uint64_t shares_of_group) {
        reached += shares_of_group;
        const auto now = static_cast<std::uint64_t>(static_cast<WideSum>(task.mass) * reached / whole);
        const auto own = static_cast<std::uint32_t>(now - before);
        before = now;
        return own;
      };
      std::uint32_t children = 0;
      for (; children < shares.count(); ++children) {
        ChildRow& child = batch.child_rows[first + children];
        child.count = mass_after(batch.group_sums[first + children]) & INT32_MAX;
        row.upper_sum += max(child.upper_sum, child.lower_sum);
        row.lower_sum += child.lower_sum;
      }
      if (reached < whole) {
        batch.child_rows[first + children++] = empty_row(ended, mass_after(whole - reached), true);
      }
      row.child_count = children;
      batch.action_rows[place] = row;
    }
    __syncwarp();
  }
}

}  // namespace hypgen::cuda
