// SPDX-License-Identifier: Apache-2.0
// First kernel of a batch: the members of each leaf, its history, and its legal actions.
#pragma once

#include "hypgen/cuda/batch.cuh"
#include "hypgen/model/model.hpp"

namespace hypgen::cuda {

// What a member of the parent became.
template <class M>
struct Successor {
  typename M::State next;
  typename M::Key key;
  bool terminal;
};

// Not inlined: it is called twice, and is a large part of what nvcc compiles.
template <class M>
__device__ __noinline__ Successor<M> simulate_member(const Batch<M>& batch, const LeafTask& task,
                                                     std::uint32_t i) {
  const std::uint32_t* const block = block_of<M>(batch.members, task.parent_base);
  const std::uint32_t scenario = block[i];
  const typename M::State state = load_state<M>(block, task.parent_count, i);
  const typename M::Fixed& fixed = batch.fixed[scenario];
  PhiloxDraws draws(batch.search.key, batch.search.first_scenario + scenario,
                    static_cast<std::uint32_t>(task.depth - 1));
  Successor<M> result{};
  const StepResult step = M::step(*batch.params, fixed, state, task.action, draws, result.next);
  result.terminal = step.terminal;
  if (!step.terminal) result.key = M::observe(*batch.params, fixed, state, task.action, draws, result.next);
  return result;
}

// Finds the leaf's members among its parent's: those that saw what member `first` saw, in order.
template <class M>
__device__ void find_members(const Batch<M>& batch, int leaf) {
  __shared__ typename M::Key wanted;
  __shared__ std::uint32_t warp_counts[kBlock / kWarp];
  const LeafTask& task = batch.tasks[leaf];
  if (threadIdx.x == 0) wanted = simulate_member(batch, task, task.first).key;
  __syncthreads();
  const std::uint32_t* const parents = block_of<M>(batch.members, task.parent_base);
  std::uint32_t* const own = block_of<M>(batch.members, task.base);
  std::uint32_t found = 0;
  for (std::uint32_t start = 0; start < task.parent_count; start += blockDim.x) {
    const std::uint32_t i = start + threadIdx.x;
    Successor<M> successor{};
    bool is_member = false;
    if (i < task.parent_count) {
      successor = simulate_member(batch, task, i);
      is_member = !successor.terminal && successor.key == wanted;
    }
    std::uint32_t total = 0;
    const std::uint32_t rank = found + rank_in_block(is_member, warp_counts, total);
    if (is_member && rank < task.count) store_member<M>(own, task.count, rank, parents[i], successor.next);
    if (M::kHasHistory && i == task.first) {
      M::advance_history(*batch.params, batch.fixed[parents[i]], load_state<M>(parents, task.parent_count, i),
                         task.action, wanted, successor.next, batch.histories[task.parent],
                         batch.histories[task.node]);
    }
    found += total;
  }
  if (found != task.count && threadIdx.x == 0) atomicOr(&batch.flags[leaf], kMembersFlag);
  __syncthreads();
}

// Lists the actions to try. Legality reads visible variables only, and those are equal in all members.
template <class M>
__device__ void list_actions(const Batch<M>& batch, int leaf) {
  __shared__ std::uint32_t warp_counts[kBlock / kWarp];
  const LeafTask& task = batch.tasks[leaf];
  std::int32_t* const legal = batch.legal + std::size_t(leaf) * batch.max_actions;
  const std::uint32_t* const block = block_of<M>(batch.members, task.base);
  const typename M::State state = load_state<M>(block, task.count, 0);
  const typename M::Fixed& fixed = batch.fixed[block[0]];
  const bool all = task.wanted == kAllLegal;
  const std::uint32_t candidates = all ? M::kActionCount : task.wanted_count;
  std::uint32_t found = 0;
  for (std::uint32_t start = 0; start < candidates; start += blockDim.x) {
    const std::uint32_t i = start + threadIdx.x;
    std::int32_t action = kNoStep;
    bool takes = false;
    if (i < candidates) {
      action = all ? static_cast<std::int32_t>(i) : batch.wanted[task.wanted + i];
      takes = action == kNoStep || M::is_legal(*batch.params, fixed, state, action);
    }
    std::uint32_t total = 0;
    const std::uint32_t rank = rank_in_block(takes, warp_counts, total);
    if (takes) legal[found + rank] = action;
    found += total;
  }
  if (threadIdx.x == 0) {
    batch.legal_count[leaf] = found;
    if (task.baseline >= 0) legal[found] = task.baseline;
  }
}

template <class M>
__global__ void __launch_bounds__(kBlock) gather(const __grid_constant__ Batch<M> batch) {
  const int leaf = static_cast<int>(blockIdx.x);
  if (threadIdx.x == 0) {
    batch.flags[leaf] = 0;
    if (leaf == 0) batch.next_item[0] = batch.next_item[1] = *batch.leaves_done = 0;
  }
  __syncthreads();
  if (batch.tasks[leaf].parent != kNoParent) find_members(batch, leaf);
  list_actions(batch, leaf);
}

}  // namespace hypgen::cuda
