// SPDX-License-Identifier: Apache-2.0
// The sizes of an evaluator's parts on a GPU, and the launch shapes with which its kernels fill the device.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "hypgen/cuda/slot.cuh"
#include "hypgen/leaves/leaf_evaluator.hpp"

namespace hypgen::cuda {

constexpr std::size_t kSlots = 3;  // batches in flight
constexpr std::size_t kMostNodes = std::size_t{1} << 22;

template <class M>
struct DeviceSizes {
  static constexpr Pass kLastPass = kHasRollouts<M> ? Pass::kRollouts : Pass::kFirstSteps;

  LaunchShape launch;
  std::size_t nodes = 0;
  std::size_t members = 0;  // of all nodes

  // Attributes belong to a kernel and a device: they must be the same for all evaluators of the model.
  bool shape(const EvaluatorOptions& options, int device, std::string& error) {
    cudaDeviceProp properties;
    if (!worked(cudaGetDeviceProperties(&properties, device), "GPU", error)) return false;
    launch.table_capacity = static_cast<std::uint32_t>(options.max_scenarios);
    launch.weighs = options.may_weigh;
    launch.parent_capacity = std::max(kLeastParents, 4 * options.max_scenarios);
    const std::size_t table = launch.table_stride();
    const std::size_t most = std::min<std::size_t>(kSharedTable, properties.sharedMemPerBlockOptin / 2);
    launch.table_bytes = table <= most ? table : 0;
    int simulating = 0, reducing = 0;
    if (!worked(cudaFuncSetAttribute(reduce<M>, cudaFuncAttributeMaxDynamicSharedMemorySize,
                                     static_cast<int>(most)),
                "shared memory", error) ||
        !worked(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&simulating, simulate<M, kLastPass>,
                                                              kSimulateBlock, 0),
                "GPU", error) ||
        !worked(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&reducing, reduce<M>, kReduceBlock,
                                                              launch.table_bytes),
                "GPU", error)) {
      return false;
    }
    launch.warps = options.warps;
    launch.multiprocessors = properties.multiProcessorCount;
    launch.together_bytes = sizeof(SharedSteps<M>);
    if constexpr (M::kMaxWarps > 1) {
      // A state that is too large for shared memory is stepped by single lanes.
      if (launch.together_bytes + sizeof(LeafOffsets) + 1024 <= properties.sharedMemPerBlockOptin) {
        launch.most_warps = std::min<int>(M::kMaxWarps, kMostWarps);
        const auto bytes = static_cast<int>(launch.together_bytes);
        if (!worked(cudaFuncSetAttribute(simulate_together<M, Pass::kFirstSteps>,
                                         cudaFuncAttributeMaxDynamicSharedMemorySize, bytes),
                    "shared memory", error) ||
            !worked(cudaFuncSetAttribute(simulate_together<M, kLastPass>,
                                         cudaFuncAttributeMaxDynamicSharedMemorySize, bytes),
                    "shared memory", error)) {
          return false;
        }
      }
    }
    launch.simulate_blocks = std::max(1, simulating) * properties.multiProcessorCount;
    launch.reduce_blocks = std::max(1, reducing) * properties.multiProcessorCount;
    return true;
  }

  // Divides the budget: what the slots take whatever the number of items; the items; the histories; and the
  // members with all that is left.
  bool share_out(std::size_t budget, const EvaluatorOptions& options, std::string& error) {
    const std::size_t scenarios = options.max_scenarios;
    const std::size_t member = kMemberWords<M> * sizeof(std::uint32_t);
    const std::size_t item = kSlots * Slot<M>::bytes_an_item(launch);
    if (launch.table_bytes == 0) {
      const std::size_t tables = budget / 4 / kSlots / launch.table_stride();
      launch.reduce_blocks = static_cast<int>(
          std::clamp<std::size_t>(tables, 1, static_cast<std::size_t>(launch.reduce_blocks)));
    }
    const std::size_t apart =
        kSlots * Slot<M>::bytes_but_items(launch) + scenarios * sizeof(typename M::Fixed);
    const std::size_t largest_leaf = scenarios * Slot<M>::kMaxActions;
    const std::size_t needed = apart + largest_leaf * item + kLeastNodeBytes + 4 * scenarios * member;
    if (needed > budget) {
      error = "a leaf of " + std::to_string(scenarios) + " scenarios needs " + std::to_string(needed >> 20) +
              " MB of GPU memory, which has " + std::to_string(budget >> 20) +
              " MB for this solver: lower --scenarios or raise --device-memory";
      return false;
    }
    launch.item_capacity = std::max(largest_leaf, std::min(kItems, (budget - apart) / 2 / item));
    const std::size_t rest = budget - apart - launch.item_capacity * item;
    const std::size_t history = M::kHasHistory ? sizeof(typename M::History) : 0;
    nodes = M::kHasHistory ? std::min(kMostNodes, rest / 4 / history) : kMostNodes;
    members = std::min<std::size_t>(UINT32_MAX - 1, (rest - nodes * history) / member);
    return true;
  }

 private:
  static constexpr std::size_t kItems = std::size_t{4} << 20;         // of a batch, where memory allows
  static constexpr std::size_t kLeastParents = std::size_t{1} << 14;  // members of parents in a batch
  static constexpr std::size_t kSharedTable = 100 << 10;  // bytes: two blocks fit a multiprocessor
  static constexpr std::size_t kLeastNodeBytes = std::size_t{64} << 20;
};

}  // namespace hypgen::cuda
