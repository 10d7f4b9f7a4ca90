// SPDX-License-Identifier: Apache-2.0
// Last kernel of a batch: rows to the host's memory.
#pragma once

#include "hypgen/cuda/batch.cuh"
#include "hypgen/model/model.hpp"

namespace hypgen::cuda {

template <class M>
__device__ std::int64_t one_ply_return(const Batch<M>& batch, std::uint32_t item) {
  return batch.rewards[item] +
         static_cast<std::int64_t>(batch.search.discount * static_cast<double>(batch.lowers[item]));
}

// An action's gains over the baseline, in the order of the members: sums of doubles must not depend on
// threads.
template <class M>
__device__ void write_gains(const Batch<M>& batch, const LeafTask& task, std::uint32_t actions,
                            std::uint32_t first_item, RowLine* target) {
  Gain* const gains = reinterpret_cast<Gain*>(target);
  const std::uint32_t baseline = first_item + actions * task.count;
  for (std::uint32_t a = threadIdx.x; a < actions; a += blockDim.x) {
    Gain gain{0, 0.0};
    for (std::uint32_t i = 0; i < task.count; ++i) {
      const std::int64_t difference =
          one_ply_return(batch, first_item + a * task.count + i) - one_ply_return(batch, baseline + i);
      gain.sum += difference;
      gain.square_sum +=
          from_fixed_sum<kRewardBits<M>>(difference) * from_fixed_sum<kRewardBits<M>>(difference);
    }
    gains[a] = gain;
  }
}

// Takes room for rows; false if there is none.
template <class M>
__device__ bool take_lines(const Batch<M>& batch, std::uint32_t count, std::uint32_t& first) {
  first = atomicAdd(batch.arena_used, count);
  if (first <= batch.arena_size && count <= batch.arena_size - first) return true;
  atomicSub(batch.arena_used, count);
  return false;
}

// Copies a leaf's action rows to the host's memory. Here as below threads take consecutive words of the
// target: writes across the bus should fill whole lines.
__device__ inline void copy_actions(const ActionRow* action_rows, std::uint32_t actions, RowLine* target) {
  constexpr std::uint32_t kWords = sizeof(ActionRow) / sizeof(unsigned long long);
  const auto* const from = reinterpret_cast<const unsigned long long*>(action_rows);
  auto* const to = reinterpret_cast<unsigned long long*>(target);
  for (std::uint32_t w = threadIdx.x; w < actions * kWords; w += blockDim.x) to[w] = from[w];
}

// Copies a leaf's child rows, which lie action by action, to one run.
template <class M>
__device__ void copy_children(const Batch<M>& batch, const ActionRow* action_rows, std::uint32_t first_item,
                              std::uint32_t actions, std::uint32_t children, RowLine* target) {
  constexpr std::uint32_t kWords = sizeof(ChildRow) / sizeof(unsigned long long);
  const std::uint32_t count = batch.tasks[blockIdx.x].count;
  auto* const to = reinterpret_cast<unsigned long long*>(target);
  for (std::uint32_t w = threadIdx.x; w < children * kWords; w += blockDim.x) {
    const std::uint32_t child = w / kWords;
    std::uint32_t low = 0, high = actions;  // the action: the last whose children start at or before this one
    while (high - low > 1) {
      const std::uint32_t middle = (low + high) / 2;
      if (action_rows[middle].first_child <= child) {
        low = middle;
      } else {
        high = middle;
      }
    }
    const std::uint32_t row = first_item + low * count + child - action_rows[low].first_child;
    to[w] = reinterpret_cast<const unsigned long long*>(batch.child_rows + row)[w % kWords];
  }
}

template <class M>
__global__ void __launch_bounds__(kBlock) ship(const __grid_constant__ Batch<M> batch) {
  __shared__ LeafOffsets items;
  __shared__ std::uint32_t warp_sums[kBlock / kWarp];
  __shared__ std::uint32_t first_line;
  __shared__ bool fits;
  items.fill(batch.leaves, [&](int leaf) { return items_of(batch, leaf); });
  const int leaf = static_cast<int>(blockIdx.x);
  const LeafTask& task = batch.tasks[leaf];
  const std::uint32_t actions = batch.legal_count[leaf], first_item = items.starts[leaf];
  ActionRow* const action_rows = batch.action_rows + std::size_t(leaf) * batch.max_actions;

  std::uint32_t children = 0;
  for (std::uint32_t start = 0; start < actions; start += blockDim.x) {
    const std::uint32_t a = start + threadIdx.x;
    std::uint32_t total = 0;
    const std::uint32_t before =
        scan_in_block(a < actions ? action_rows[a].child_count : 0, warp_sums, total);
    if (a < actions) action_rows[a].first_child = children + before;
    children += total;
  }
  const bool has_gains = task.baseline >= 0;
  const RowLayout layout(actions, has_gains, children);
  if (threadIdx.x == 0) fits = take_lines(batch, layout.end, first_line);
  __syncthreads();

  if (fits) {
    RowLine* const run = batch.arena + first_line;
    copy_actions(action_rows, actions, run);
    if (has_gains) write_gains(batch, task, actions, first_item, run + layout.gains);
    copy_children(batch, action_rows, first_item, actions, children, run + layout.children);
  }
  if (threadIdx.x == 0) {
    LeafOutcome outcome{};
    outcome.action_count = actions;
    outcome.first_line = first_line;
    outcome.child_count = children;
    outcome.flags = batch.flags[leaf] | (fits ? 0U : kFullFlag);
    batch.outcomes[leaf] = outcome;
  }
  __threadfence_system();
  __syncthreads();
  if (threadIdx.x == 0 && atomicAdd(batch.leaves_done, 1) + 1 == static_cast<std::uint32_t>(batch.leaves)) {
    __threadfence_system();
    *batch.out_steps = *batch.steps;
    __threadfence_system();
    *batch.done = batch.number;
  }
}

}  // namespace hypgen::cuda
