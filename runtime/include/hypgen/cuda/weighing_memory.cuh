// SPDX-License-Identifier: Apache-2.0
// The device memory of a batch of a weighted search.
#pragma once

#include <cstddef>
#include <string>

#include "hypgen/cuda/batch.cuh"
#include "hypgen/cuda/memory.cuh"

namespace hypgen::cuda {

template <class M>
class WeighedArrays {
 public:
  bool allocate(std::size_t count, std::string& error) {
    constexpr std::size_t kShared = WeighedItems<M>::kShared;
    return nexts_.allocate(count, error) &&
           group_nexts_.allocate(kKeyHoldsState<M> ? count * kShared : 1, error) &&
           posteriors_.allocate(count * kShared, error) && shares_.allocate(count * kShared, error) &&
           sums_.allocate(count, error) && numbers_.allocate(count * WeighedItems<M>::kNumbers, error);
  }
  WeighedItems<M> items() const {
    return {nexts_.get(), group_nexts_.get(), posteriors_.get(), shares_.get(), sums_.get(), numbers_.get()};
  }

 private:
  DeviceArray<typename M::State> nexts_, group_nexts_;
  DeviceArray<double> posteriors_;
  DeviceArray<std::uint64_t> sums_;
  DeviceArray<std::uint32_t> shares_, numbers_;
};

template <class M>
class WeighingMemory {
 public:
  static std::size_t bytes_an_item() {
    constexpr std::size_t kElsewhere =
        kKeyHoldsState<M> ? WeighedItems<M>::kShared * (sizeof(GroupBounds) + sizeof(Extra)) : 0;
    return WeighedItems<M>::kBytes + sizeof(std::uint32_t) + sizeof(std::uint64_t) + kElsewhere;
  }
  static std::size_t bytes_but_items(std::size_t rows, std::size_t parents) {
    return rows * sizeof(ScenarioShares<M>) +
           parents * (WeighedItems<M>::kBytes + sizeof(typename M::Key) + 1);
  }

  // `rows`: actions of all leaves; `parents`: members of parents.
  bool allocate(std::size_t items, std::size_t rows, std::size_t parents, std::string& error) {
    const std::size_t elsewhere = kKeyHoldsState<M> ? items * WeighedItems<M>::kShared : 1;
    return items_.allocate(items, error) && parents_.allocate(parents, error) &&
           parent_keys_.allocate(parents, error) && parent_terminals_.allocate(parents, error) &&
           seen_by_.allocate(items, error) && group_sums_.allocate(items, error) &&
           group_bounds_.allocate(elsewhere, error) && extras_.allocate(elsewhere, error) &&
           action_shares_.allocate(rows, error);
  }

  void lend(Batch<M>& batch) const {
    batch.parents = parents_.items();
    batch.parent_keys = parent_keys_.get();
    batch.parent_terminals = parent_terminals_.get();
    batch.items = items_.items();
    batch.seen_by = seen_by_.get();
    batch.group_sums = group_sums_.get();
    batch.group_bounds = group_bounds_.get();
    batch.extras = extras_.get();
    batch.action_shares = action_shares_.get();
  }

 private:
  WeighedArrays<M> items_, parents_;
  DeviceArray<typename M::Key> parent_keys_;
  DeviceArray<std::uint8_t> parent_terminals_;
  DeviceArray<std::uint32_t> seen_by_;
  DeviceArray<std::uint64_t> group_sums_;
  DeviceArray<GroupBounds> group_bounds_;
  DeviceArray<Extra> extras_;
  DeviceArray<ScenarioShares<M>> action_shares_;
};

}  // namespace hypgen::cuda
