// SPDX-License-Identifier: Apache-2.0
// One batch in flight: its stream, its memory and where its rows go.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>

#include "hypgen/core/span.hpp"
#include "hypgen/cuda/batch.cuh"
#include "hypgen/cuda/choose.cuh"
#include "hypgen/cuda/gather.cuh"
#include "hypgen/cuda/memory.cuh"
#include "hypgen/cuda/reduce.cuh"
#include "hypgen/cuda/ship.cuh"
#include "hypgen/cuda/simulate.cuh"
#include "hypgen/cuda/weigh.cuh"
#include "hypgen/cuda/weighing_memory.cuh"
#include "hypgen/leaves/leaf_evaluator.hpp"

namespace hypgen::cuda {

// How a device is filled by the kernels of a model.
struct LaunchShape {
  int simulate_blocks = 0;  // that run at once
  int reduce_blocks = 0;
  std::uint32_t table_capacity = 0;  // members of the largest leaf
  std::size_t table_bytes = 0;       // of shared memory; 0: tables are in device memory
  std::size_t item_capacity = 0;
  int warps = 0;  // that share the steps of a lane; 0: chosen for each batch
  int most_warps = 1;
  std::size_t together_bytes = 0;  // of shared memory
  int multiprocessors = 1;
  bool weighs = false;              // some search may be weighted
  std::size_t parent_capacity = 0;  // of parents' members, in a weighted search

  // Bytes of a table of groups, such that another can follow it.
  std::size_t table_stride() const { return (GroupTable::bytes_for(table_capacity) + 15) / 16 * 16; }
};

// How many warps share a step: several only where lanes alone would leave most of the device idle.
inline int warps_for(const LaunchShape& shape, std::size_t items) {
  constexpr std::size_t kBusyThreads = 256;  // a multiprocessor
  int warps = shape.warps > 0 ? std::min(shape.warps, shape.most_warps) : 1;
  if (shape.warps > 0) return warps;
  const std::size_t room = kBusyThreads * static_cast<std::size_t>(shape.multiprocessors);
  while (2 * warps <= shape.most_warps && items * 2 * static_cast<std::size_t>(warps) <= room) warps *= 2;
  return warps;
}

// Launches batches one at a time. Everything that a batch needs for itself is taken by `make`.
template <class M>
class Slot {
 public:
  static constexpr int kMaxActions = M::kActionCount + 1;  // and a baseline
  static constexpr std::size_t kWantedCapacity = std::size_t{4} * kMaxActions;

  static std::size_t bytes_an_item(const LaunchShape& shape) {
    const std::size_t always = sizeof(typename M::Key) + 3 * sizeof(std::int64_t) + 1 + sizeof(ChildRow);
    return always + (shape.weighs ? WeighingMemory<M>::bytes_an_item() : 0);
  }

  // Of device memory, that a slot takes besides its items.
  static std::size_t bytes_but_items(const LaunchShape& shape) {
    return kRows * (sizeof(ActionRow) + sizeof(std::int32_t)) +
           rolled_rows(shape) * (sizeof(std::uint32_t) + sizeof(double)) + kMaxLeaves * sizeof(LeafTask) +
           (shape.weighs ? WeighingMemory<M>::bytes_but_items(kRows, shape.parent_capacity) : 0) +
           kLeafWords * sizeof(std::uint32_t) + kWantedCapacity * sizeof(std::int32_t) + tables_bytes(shape);
  }

  Slot() = default;
  Slot(const Slot&) = delete;
  Slot& operator=(const Slot&) = delete;
  ~Slot() {
    if (stream_ != nullptr) {
      cudaStreamSynchronize(stream_);
      cudaStreamDestroy(stream_);
    }
  }

  bool make(const LaunchShape& shape, std::string& error) {
    shape_ = shape;
    const std::size_t items = shape.item_capacity, tables = tables_bytes(shape);
    return worked(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "stream", error) &&
           started_.make(error) && ended_.make(error) && keys_.allocate(items, error) &&
           rewards_.allocate(items, error) && uppers_.allocate(items, error) &&
           lowers_.allocate(items, error) && terminals_.allocate(items, error) &&
           child_rows_.allocate(items, error) && action_rows_.allocate(kRows, error) &&
           legal_.allocate(kRows, error) && rolled_.allocate(rolled_rows(shape), error) &&
           promises_.allocate(rolled_rows(shape), error) &&
           (!shape.weighs || weighing_.allocate(items, kRows, shape.parent_capacity, error)) &&
           leaf_words_.allocate(kLeafWords, error) && (tables == 0 || tables_.allocate(tables, error)) &&
           device_tasks_.allocate(kMaxLeaves, error) && device_wanted_.allocate(kWantedCapacity, error) &&
           tasks_.allocate(kMaxLeaves, error) && wanted_.allocate(kWantedCapacity, error) &&
           outcomes_.allocate(kMaxLeaves, error) && done_.allocate(1, error) && clear(error);
  }

  // Filling -------------------------------------------------------------------------------------------

  bool empty() const { return leaves_ == 0; }
  int leaves() const { return leaves_; }
  void reset() {
    leaves_ = 0;
    items_ = rolled_items_ = units_ = parents_ = 0;
    wanted_count_ = 0;
  }

  // Whether another leaf of so many members, parents' members and candidate actions has room. The first one always
  // has; more than `most_items` are not taken with others.
  bool fits(std::size_t count, std::size_t parents, std::size_t actions, bool lists_them,
            std::size_t most_items) const {
    return leaves_ == 0 ||
           (leaves_ < kMaxLeaves && (!shape_.weighs || parents_ + parents <= shape_.parent_capacity) &&
            items_ + count * actions <= std::min(most_items, shape_.item_capacity) &&
            (!lists_them || wanted_count_ + actions <= kWantedCapacity));
  }
  std::size_t items() const { return items_; }

  void add(LeafTask task, Span<const int> actions) {
    task.wanted = kAllLegal;
    task.wanted_count = 0;
    if (!actions.empty()) {
      task.wanted = wanted_count_;
      task.wanted_count = static_cast<std::uint32_t>(actions.size());
      std::memcpy(wanted_.get() + wanted_count_, actions.begin(), actions.size() * sizeof(int));
      wanted_count_ += task.wanted_count;
    }
    const std::size_t candidates = actions.empty() ? M::kActionCount : actions.size();
    items_ += (candidates + (task.baseline >= 0 ? 1 : 0)) * task.count;
    rolled_items_ += std::min<std::size_t>(std::size_t{task.rolled} + 1, candidates + 1) * task.count;
    units_ += candidates;
    parents_ += task.parent == kNoParent ? 0 : task.parent_count;
    tasks_[static_cast<std::size_t>(leaves_++)] = task;
  }

  // Running -------------------------------------------------------------------------------------------

  bool launch(Batch<M> batch, std::string& error) {
    static_assert(sizeof(int) == sizeof(std::int32_t));
    batch.leaves = leaves_;
    batch.max_actions = kMaxActions;
    batch.tasks = device_tasks_.get();
    batch.wanted = device_wanted_.get();
    batch.legal = legal_.get();
    batch.legal_count = leaf_words_.get();
    batch.flags = leaf_words_.get() + kMaxLeaves;
    batch.rolled_count = leaf_words_.get() + 2 * kMaxLeaves;
    batch.next_item = leaf_words_.get() + 3 * kMaxLeaves;
    batch.leaves_done = batch.next_item + 2;
    batch.extra_count = batch.next_item + 3;
    if (shape_.weighs) weighing_.lend(batch);
    batch.rolled = rolled_.get();
    batch.promises = promises_.get();
    batch.keys = keys_.get();
    batch.rewards = rewards_.get();
    batch.uppers = uppers_.get();
    batch.lowers = lowers_.get();
    batch.terminals = terminals_.get();
    batch.child_rows = child_rows_.get();
    batch.action_rows = action_rows_.get();
    batch.outcomes = outcomes_.get();
    batch.done = done_.get();
    batch.number = ++number_;
    running_ = true;
    launched_ = Clock::now();
    cudaMemcpyAsync(device_tasks_.get(), tasks_.get(), sizeof(LeafTask) * static_cast<std::size_t>(leaves_),
                    cudaMemcpyHostToDevice, stream_);
    if (wanted_count_ > 0) {
      cudaMemcpyAsync(device_wanted_.get(), wanted_.get(), sizeof(std::int32_t) * wanted_count_,
                      cudaMemcpyHostToDevice, stream_);
    }
    cudaEventRecord(started_.get(), stream_);
    if (batch.search.weighted) {
      launch_weighted(batch);
    } else {
      launch_exact(batch);
    }
    ship<M><<<leaves_, kBlock, 0, stream_>>>(batch);
    cudaEventRecord(ended_.get(), stream_);
    // The last error may be of a copy or an event of this batch too.
    return worked(cudaGetLastError(), "kernel launch", error);
  }

  // Whether the rows are there. Looks at the stream's health now and then.
  bool finished(std::string& error) {
    if (!running_) return true;
    if (__atomic_load_n(done_.get(), __ATOMIC_ACQUIRE) == number_) {  // std::atomic_ref is C++20
      running_ = false;
      return true;
    }
    if (++polls_ % kPollsBetweenQueries == 0) {
      const cudaError_t health = cudaStreamQuery(stream_);
      if (health != cudaErrorNotReady) worked(health, "GPU", error);
    }
    return false;
  }
  bool running() const { return running_; }
  Clock::time_point launched() const { return launched_; }

  // When the latest batch started and ended, in seconds after `origin`; false if there was none.
  bool times(cudaEvent_t origin, double& started, double& ended) const {
    float first = 0.0F, last = 0.0F;
    if (number_ == 0 || cudaEventSynchronize(ended_.get()) != cudaSuccess ||
        cudaEventElapsedTime(&first, origin, started_.get()) != cudaSuccess ||
        cudaEventElapsedTime(&last, origin, ended_.get()) != cudaSuccess) {
      return false;
    }
    started = 1e-3 * static_cast<double>(first);
    ended = 1e-3 * static_cast<double>(last);
    return true;
  }

  const LeafTask& task(int leaf) const { return tasks_[static_cast<std::size_t>(leaf)]; }
  const LeafOutcome& outcome(int leaf) const { return outcomes_[static_cast<std::size_t>(leaf)]; }
  cudaStream_t stream() const { return stream_; }

 private:
  static constexpr std::uint64_t kPollsBetweenQueries = 1 << 14;
  static constexpr std::size_t kRows = std::size_t{kMaxLeaves} * kMaxActions;
  static constexpr std::size_t kLeafWords = 3 * kMaxLeaves + 4;

  static std::size_t rolled_rows(const LaunchShape& shape) {
    return kHasRollouts<M> || shape.weighs ? kRows : 1;
  }

  // Of tables in device memory, where they do not fit shared memory.
  static std::size_t tables_bytes(const LaunchShape& shape) {
    return shape.table_bytes > 0 ? 0 : shape.table_stride() * static_cast<std::size_t>(shape.reduce_blocks);
  }

  static unsigned blocks(std::size_t work, int most) {
    return static_cast<unsigned>(std::clamp<std::size_t>(work, 1, static_cast<std::size_t>(most)));
  }

  // The kernels of a batch but for the last one.
  void launch_exact(const Batch<M>& batch) {
    gather<M><<<leaves_, kBlock, 0, stream_>>>(batch);
    launch_simulate<Pass::kFirstSteps>(batch, items_);
    if constexpr (kHasRollouts<M>) {
      choose_rolled<M><<<leaves_, kBlock, 0, stream_>>>(batch);
      launch_simulate<Pass::kRollouts>(batch, rolled_items_);
    }
    reduce<M><<<blocks(units_, shape_.reduce_blocks), kReduceBlock, shape_.table_bytes, stream_>>>(
        batch, tables_.get(), shape_.table_capacity, shape_.table_stride());
  }

  void launch_weighted(const Batch<M>& batch) {
    constexpr std::size_t kWarps = kBlock / kWarp;
    gather_weighted<M><<<leaves_, kBlock, 0, stream_>>>(batch);
    launch_simulate<Pass::kFirstSteps>(batch, items_);
    choose_rolled<M><<<leaves_, kBlock, 0, stream_>>>(batch);
    weigh<M><<<blocks(units_, shape_.reduce_blocks), kWeighBlock, 0, stream_>>>(batch);
    launch_simulate<Pass::kWeighted>(batch, rolled_items_);
    reduce_weighted<M>
        <<<blocks((units_ + kWarps - 1) / kWarps, shape_.reduce_blocks), kBlock, 0, stream_>>>(batch);
  }

  // `items`: how many the pass has, at most.
  template <Pass pass>
  void launch_simulate(const Batch<M>& batch, std::size_t items) {
    if constexpr (M::kMaxWarps > 1) {
      const int warps = warps_for(shape_, items);
      if (warps > 1) return launch_together<pass>(batch, items, warps);
    }
    simulate<M, pass><<<blocks((items + kSimulateBlock - 1) / kSimulateBlock, shape_.simulate_blocks),
                        kSimulateBlock, 0, stream_>>>(batch);
  }

  template <Pass pass>
  void launch_together(const Batch<M>& batch, std::size_t items, int warps) {
    constexpr int kResidentWarps = 64;  // a multiprocessor
    const int most = shape_.multiprocessors * kResidentWarps / warps;
    simulate_together<M, pass>
        <<<blocks((items + kWarp - 1) / kWarp, most), static_cast<unsigned>(warps) * kWarp,
           shape_.together_bytes, stream_>>>(batch);
  }

  bool clear(std::string& error) {
    *done_.get() = 0;
    return worked(cudaMemset(leaf_words_.get(), 0, sizeof(std::uint32_t) * kLeafWords), "GPU", error);
  }

  LaunchShape shape_;
  cudaStream_t stream_ = nullptr;
  Event started_, ended_;
  int leaves_ = 0;
  std::size_t items_ = 0;         // at most
  std::size_t rolled_items_ = 0;  // at most
  std::size_t units_ = 0;         // of `reduce`, at most
  std::size_t parents_ = 0;       // members of parents
  std::uint32_t wanted_count_ = 0;
  std::uint32_t number_ = 0;
  std::uint64_t polls_ = 0;
  bool running_ = false;
  Clock::time_point launched_{};

  DeviceArray<typename M::Key> keys_;
  DeviceArray<std::int64_t> rewards_, uppers_, lowers_;
  DeviceArray<std::uint8_t> terminals_;
  DeviceArray<ChildRow> child_rows_;
  DeviceArray<ActionRow> action_rows_;
  DeviceArray<std::int32_t> legal_, device_wanted_;
  DeviceArray<std::uint32_t> rolled_;
  DeviceArray<double> promises_;
  DeviceArray<std::uint32_t> leaf_words_;
  DeviceArray<unsigned char> tables_;
  WeighingMemory<M> weighing_;
  DeviceArray<LeafTask> device_tasks_;
  PinnedArray<LeafTask> tasks_;
  PinnedArray<std::int32_t> wanted_;
  PinnedArray<LeafOutcome> outcomes_;
  PinnedArray<std::uint32_t> done_;
};

}  // namespace hypgen::cuda
