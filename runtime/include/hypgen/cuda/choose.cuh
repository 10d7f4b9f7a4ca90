// SPDX-License-Identifier: Apache-2.0
// The kernel between a batch's two passes: the actions of each leaf that are rolled out.
#pragma once

#include <limits>

#include "hypgen/cuda/batch.cuh"
#include "hypgen/leaves/rolled_actions.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen::cuda {

// An action and what it promises; of equals the first counts as larger.
struct Promise {
  double value;
  std::uint32_t place;

  __device__ bool is_less(const Promise& other) const {
    return value < other.value || (value == other.value && place > other.place);
  }
};

__device__ inline Promise largest_in_warp(Promise mine) {
  for (unsigned offset = kWarp / 2; offset > 0; offset /= 2) {
    const Promise other{__shfl_xor_sync(kAll, mine.value, offset), __shfl_xor_sync(kAll, mine.place, offset)};
    if (mine.is_less(other)) mine = other;
  }
  return mine;
}

// A warp an action: sums its rewards and upper bounds over the leaf's members.
template <class M>
__device__ void add_promises(const Batch<M>& batch, int leaf, std::uint32_t first_item, double* promises) {
  const std::uint32_t count = batch.tasks[leaf].count, actions = batch.legal_count[leaf];
  for (std::uint32_t a = threadIdx.x / kWarp; a < actions; a += blockDim.x / kWarp) {
    std::int64_t reward = 0, upper = 0;
    for (std::uint32_t i = threadIdx.x % kWarp; i < count; i += kWarp) {
      reward += batch.rewards[first_item + a * count + i];
      upper += batch.uppers[first_item + a * count + i];
    }
    for (unsigned offset = kWarp / 2; offset > 0; offset /= 2) {
      reward += __shfl_xor_sync(kAll, reward, offset);
      upper += __shfl_xor_sync(kAll, upper, offset);
    }
    if (threadIdx.x % kWarp != 0) continue;
    if (batch.search.weighted) {
      reward = spread(reward, batch.tasks[leaf].mass, count);
      upper = spread(upper, batch.tasks[leaf].mass, count);
    }
    promises[a] = promise(reward, upper, batch.search.discount);
  }
}

// For all threads of a block: the place of the largest number, which is then taken out.
__device__ inline Promise take_largest(double* promises, std::uint32_t count) {
  __shared__ Promise of_warps[kMostBlockWarps];
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  Promise mine{kNone, UINT32_MAX};
  for (std::uint32_t a = threadIdx.x; a < count; a += blockDim.x) {
    const Promise other{promises[a], a};
    if (mine.is_less(other)) mine = other;
  }
  mine = largest_in_warp(mine);
  if (threadIdx.x % kWarp == 0) of_warps[threadIdx.x / kWarp] = mine;
  __syncthreads();
  if (threadIdx.x < kWarp) {
    mine = threadIdx.x < blockDim.x / kWarp ? of_warps[threadIdx.x] : Promise{kNone, UINT32_MAX};
    mine = largest_in_warp(mine);
    if (threadIdx.x == 0) {
      of_warps[0] = mine;
      if (mine.place < count) promises[mine.place] = kNone;
    }
  }
  __syncthreads();
  const Promise found = of_warps[0];
  __syncthreads();
  return found;
}

// The place of the default policy's action among the legal ones; UINT32_MAX: it is not there.
template <class M>
__device__ std::uint32_t default_place(const Batch<M>& batch, int leaf, const std::int32_t* legal) {
  const LeafTask& task = batch.tasks[leaf];
  const std::uint32_t* const block = block_of<M>(batch.members, task.base);
  const std::uint32_t scenario = block[0], number = batch.search.weighted ? 0 : scenario;
  PhiloxDraws draws(batch.search.key, batch.search.first_scenario + number,
                    static_cast<std::uint32_t>(task.depth));
  typename M::History history{};
  if constexpr (M::kHasHistory) history = batch.histories[task.node];
  const int action = M::default_policy(*batch.params, batch.fixed[scenario],
                                       load_state<M>(block, task.count, 0), history, draws);
  for (std::uint32_t a = 0; a < batch.legal_count[leaf]; ++a) {
    if (legal[a] == action) return a;
  }
  return UINT32_MAX;
}

// A block a leaf.
template <class M>
__global__ void __launch_bounds__(kBlock) choose_rolled(const __grid_constant__ Batch<M> batch) {
  __shared__ LeafOffsets items;
  items.fill(batch.leaves, [&](int leaf) { return items_of(batch, leaf); });
  const int leaf = static_cast<int>(blockIdx.x);
  const LeafTask& task = batch.tasks[leaf];
  const std::size_t list = std::size_t(leaf) * batch.max_actions;
  std::uint32_t* const rolled = batch.rolled + list;
  if (task.rolled == kRollsAll || !kHasRollouts<M>) {
    const std::uint32_t all = items_of(batch, leaf) / task.count;
    for (std::uint32_t a = threadIdx.x; a < all; a += blockDim.x) rolled[a] = a;
    if (threadIdx.x == 0) batch.rolled_count[leaf] = all;
    return;
  }
  const std::uint32_t actions = batch.legal_count[leaf];
  double* const promises = batch.promises + list;
  add_promises(batch, leaf, items.starts[leaf], promises);
  __syncthreads();
  std::uint32_t count = 0;
  while (count < min(task.rolled, actions)) {
    const Promise best = take_largest(promises, actions);
    if (!can_raise(best.value, task.lower_sum)) break;
    if (threadIdx.x == 0) rolled[count] = best.place;
    ++count;
  }
  if (threadIdx.x == 0) {
    const std::uint32_t own = default_place(batch, leaf, batch.legal + list);
    bool is_new = own != UINT32_MAX;
    for (std::uint32_t r = 0; r < count; ++r) is_new &= rolled[r] != own;
    if (is_new) rolled[count++] = own;
    batch.rolled_count[leaf] = count;
  }
}

}  // namespace hypgen::cuda
