// SPDX-License-Identifier: Apache-2.0
// Expands leaves on a GPU, many at a time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "hypgen/cuda/driver.cuh"
#include "hypgen/cuda/sizes.cuh"
#include "hypgen/leaves/horizon_floors.hpp"
#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/leaves/leaf_ring.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen::cuda {

// Keeps, of each expanded leaf, its history and its scenarios' numbers and states in device memory. Each
// thread of the search has a ring of leaves; whoever finds its own not ready drives the device for all, if
// nobody does.
template <class M>
class CudaEvaluator final : public LeafEvaluator {
 public:
  // Null and `error` if the device, its memory or that of the host does not suffice.
  static std::unique_ptr<CudaEvaluator> make(const typename M::Params& params,
                                             const EvaluatorOptions& options, int device,
                                             std::string& error) {
    try {
      auto made = std::unique_ptr<CudaEvaluator>(new CudaEvaluator(params, options, device));
      if (made->allocate(error)) return made;
    } catch (const std::bad_alloc&) {
      error = "not enough memory of the host for a GPU's leaves";
    }
    return nullptr;
  }

  ~CudaEvaluator() override { cudaSetDevice(device_); }

  void attach(std::size_t thread) override {
    LeafEvaluator::attach(thread);
    cudaSetDevice(device_);  // of the calling thread
  }

  std::size_t threads() const override { return rings_.threads(); }

  // Lanes that share a multiprocessor slow each other down, so that half of what is resident is counted.
  std::size_t lanes() const override {
    return static_cast<std::size_t>(sizes_.launch.simulate_blocks) * kSimulateBlock / 2;
  }

  RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) override {
    release();
    const std::size_t count = root.size();
    if (count == 0 || count > options_.max_scenarios || (setup.weighted && !options_.may_weigh) ||
        setup.depth_limit > options_.max_depth ||
        !root.holds(sizeof(typename M::Fixed), sizeof(typename M::State), sizeof(typename M::History))) {
      return {Status::kEvaluatorFailed, {}, -1};
    }
    if (!driver_.settle(setup.deadline)) {
      return {driver_.is_lost() ? Status::kDeviceLost : Status::kDeadline, {}, -1};
    }
    upload(root);
    PhiloxDraws first(setup.key, 0, 0);
    RootResult result{Status::kOk, {}, -1};
    result.default_action =
        M::default_policy(*params_, staged_fixed_[0], root_states_[0], *staged_history_.get(), first);
    SearchConstants constants{};
    constants.key = setup.key;
    constants.first_scenario = root.first();
    constants.depth_limit = setup.depth_limit;
    constants.at_horizon = setup.at_horizon;
    constants.weighted = setup.weighted;
    constants.discount = options_.discount;
    driver_.begin_search(batch(constants), static_cast<std::uint32_t>(count), result.default_action);
    LeafResult bounds{};
    result.status = driver_.bound_root(setup.deadline, bounds);
    if (bounds.children.size() == 1) result.row = bounds.children[0];
    if (setup.weighted) result.row.count = static_cast<std::uint32_t>(count * kScenarioMass) & INT32_MAX;
    return result;
  }

  std::size_t submit(std::size_t thread, Span<const LeafRequest> requests) override {
    std::size_t taken = 0;
    while (taken < requests.size() && rings_[thread].submit(requests[taken])) ++taken;
    return taken;
  }

  bool poll(std::size_t thread, LeafResult& result) override {
    return rings_.poll(thread, result, [this] { driver_.drive(); });
  }

  void release() override {
    rings_.reset();
    driver_.release();
  }

  EvaluatorStats stats() const override {
    EvaluatorStats stats = driver_.stats();
    stats.steps = *static_cast<volatile unsigned long long*>(out_steps_.get());
    return stats;
  }

  std::string problem() const override { return driver_.problem(); }
  bool is_stuck() override { return driver_.is_stuck(); }

 private:
  static constexpr std::size_t kMostDeviceBytes = std::size_t{8} << 30;

  CudaEvaluator(const typename M::Params& params, const EvaluatorOptions& options, int device)
      : params_(std::make_unique<typename M::Params>(params)),
        options_(options),
        device_(device),
        rings_(std::max<std::size_t>(1, options.threads), options.in_flight),
        driver_(rings_, options.in_flight, options.patience) {
    root_states_.reserve(options.max_scenarios);
  }

  // Memory --------------------------------------------------------------------------------------------

  bool allocate(std::string& error) {
    std::size_t free = 0, total = 0;
    if (!worked(cudaSetDevice(device_), "GPU", error) ||
        !worked(cudaMemGetInfo(&free, &total), "GPU memory", error) ||
        !sizes_.shape(options_, device_, error)) {
      return false;
    }
    const std::size_t budget = options_.device_memory_bytes > 0 ? options_.device_memory_bytes
                                                                : std::min(free / 2, kMostDeviceBytes);
    if (!sizes_.share_out(budget, options_, error) || !driver_.make(sizes_, error)) return false;
    row_capacity_ = std::min<std::size_t>(UINT32_MAX / 2, options_.memory_bytes / sizeof(RowLine));
    if (!rows_.allocate(row_capacity_, error)) {
      error += "; --memory lowers the need";
      return false;
    }
    const std::size_t scenarios = options_.max_scenarios;
    return device_params_.allocate(1, error) && fixed_.allocate(scenarios, error) &&
           members_.allocate(sizes_.members * kMemberWords<M>, error) &&
           histories_.allocate(M::kHasHistory ? sizes_.nodes : 1, error) &&
           discounts_.allocate(static_cast<std::size_t>(options_.max_depth) + 1, error) &&
           floors_.allocate(static_cast<std::size_t>(options_.max_depth) + 1, error) &&
           counters_.allocate(2, error) && out_steps_.allocate(1, error) &&
           staged_fixed_.allocate(scenarios, error) &&
           staged_members_.allocate(scenarios * kMemberWords<M>, error) &&
           staged_history_.allocate(1, error) && fill(error);
  }

  bool fill(std::string& error) {
    std::vector<float> discounts;
    double power = 1.0;
    for (int t = 0; t <= options_.max_depth; ++t, power *= options_.discount) {
      discounts.push_back(static_cast<float>(power));
    }
    const std::vector<float> floors = horizon_floors<M>(options_.discount, options_.max_depth);
    *out_steps_.get() = 0;
    return worked(cudaMemcpy(discounts_.get(), discounts.data(), discounts.size() * sizeof(float),
                             cudaMemcpyHostToDevice),
                  "GPU", error) &&
           worked(cudaMemcpy(floors_.get(), floors.data(), floors.size() * sizeof(float),
                             cudaMemcpyHostToDevice),
                  "GPU", error) &&
           worked(cudaMemcpy(device_params_.get(), params_.get(), sizeof(typename M::Params),
                             cudaMemcpyHostToDevice),
                  "GPU", error) &&
           worked(cudaMemset(counters_.get(), 0, 2 * sizeof(unsigned long long)), "GPU", error) &&
           // The slots' streams do not wait for the one that these calls use.
           worked(cudaDeviceSynchronize(), "GPU", error);
  }

  // The root ------------------------------------------------------------------------------------------

  void upload(const ScenarioBuffer& root) {
    const std::size_t count = root.size();
    std::vector<typename M::State>& states = root_states_;
    states.resize(count);
    root.copy_to(staged_fixed_.get(), states.data());
    root.copy_history_to(*staged_history_.get());
    for (std::size_t i = 0; i < count; ++i) {
      staged_members_[i] = static_cast<std::uint32_t>(i);
      for (std::size_t w = 0; w < kStateWords<M>; ++w) {
        std::memcpy(&staged_members_[(1 + w) * count + i],
                    reinterpret_cast<const unsigned char*>(&states[i]) + w * sizeof(std::uint32_t),
                    sizeof(std::uint32_t));
      }
    }
    const cudaStream_t stream = driver_.stream();
    cudaMemcpyAsync(fixed_.get(), staged_fixed_.get(), count * sizeof(typename M::Fixed),
                    cudaMemcpyHostToDevice, stream);
    cudaMemcpyAsync(members_.get(), staged_members_.get(), count * kMemberWords<M> * sizeof(std::uint32_t),
                    cudaMemcpyHostToDevice, stream);
    if (M::kHasHistory) {
      cudaMemcpyAsync(histories_.get(), staged_history_.get(), sizeof(typename M::History),
                      cudaMemcpyHostToDevice, stream);
    }
    cudaMemsetAsync(counters_.get(), 0, sizeof(std::uint32_t), stream);
  }

  // What all batches of a search share.
  Batch<M> batch(const SearchConstants& search) const {
    Batch<M> batch{};
    batch.search = search;
    batch.params = device_params_.get();
    batch.discounts = discounts_.get();
    batch.floors = floors_.get();
    batch.fixed = fixed_.get();
    batch.members = members_.get();
    batch.histories = histories_.get();
    batch.arena_used = reinterpret_cast<std::uint32_t*>(counters_.get());
    batch.arena_size = static_cast<std::uint32_t>(row_capacity_);
    batch.steps = counters_.get() + 1;
    batch.out_steps = out_steps_.get();
    batch.arena = rows_.get();
    return batch;
  }

  std::unique_ptr<typename M::Params> params_;
  EvaluatorOptions options_;
  int device_;
  DeviceSizes<M> sizes_;
  std::size_t row_capacity_ = 0;  // in lines

  DeviceArray<typename M::Params> device_params_;
  DeviceArray<typename M::Fixed> fixed_;
  DeviceArray<std::uint32_t> members_;
  DeviceArray<typename M::History> histories_;
  DeviceArray<float> discounts_, floors_;
  DeviceArray<unsigned long long> counters_;  // lines of rows taken, steps simulated
  PinnedArray<RowLine> rows_;                 // of all leaves of the search
  PinnedArray<unsigned long long> out_steps_;
  PinnedArray<typename M::Fixed> staged_fixed_;
  PinnedArray<std::uint32_t> staged_members_;
  PinnedArray<typename M::History> staged_history_;
  std::vector<typename M::State> root_states_;
  LeafRings rings_;
  BatchDriver<M> driver_;  // last: it waits for its batches before memory goes
};

}  // namespace hypgen::cuda
