// SPDX-License-Identifier: Apache-2.0
// Expands leaves on the host, each thread its own.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "hypgen/leaves/cpu_scene.hpp"
#include "hypgen/leaves/cpu_worker.hpp"
#include "hypgen/leaves/leaf_evaluator.hpp"

namespace hypgen {

// A leaf is expanded when its thread asks for it, by that thread.
template <class M>
class CpuEvaluator final : public LeafEvaluator {
 public:
  CpuEvaluator(const typename M::Params& params, const EvaluatorOptions& options)
      : scene_(params, options),
        queue_size_(queue_size(options, scene_.threads)),
        states_(options.max_scenarios) {
    for (std::size_t i = 0; i < scene_.threads; ++i) {
      seats_.push_back(std::make_unique<Seat>(scene_));
      seats_.back()->queue.resize(queue_size_);
    }
    seats_[0]->worker.learn_pauses();
  }

  std::size_t threads() const override { return scene_.threads; }

  RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) override {
    release();
    scene_.setup = setup;
    const std::size_t count = root.size();
    for (const auto& seat : seats_) seat->worker.begin_search(root.first());
    if (count == 0 || count > states_.size() || setup.depth_limit > scene_.options.max_depth ||
        !root.holds(sizeof(typename M::Fixed), sizeof(typename M::State), sizeof(typename M::History))) {
      return {Status::kEvaluatorFailed, {}, -1};
    }
    typename M::History history{};
    root.copy_to(scene_.fixed.data(), states_.data());
    root.copy_history_to(history);
    return seats_[0]->worker.begin_root(states_, count, history);
  }

  std::size_t submit(std::size_t thread, Span<const LeafRequest> requests) override {
    Seat& seat = *seats_[thread];
    const std::size_t count = std::min(requests.size(), queue_size_ - seat.waiting);
    for (std::size_t i = 0; i < count; ++i) {
      seat.queue[(seat.oldest + seat.waiting++) % queue_size_] = requests[i];
    }
    return count;
  }

  bool poll(std::size_t thread, LeafResult& result) override {
    Seat& seat = *seats_[thread];
    if (seat.waiting == 0) return false;
    result = seat.worker.expand(seat.queue[seat.oldest]);
    seat.oldest = (seat.oldest + 1) % queue_size_;
    --seat.waiting;
    return true;
  }

  void release() override {
    scene_.pool.reset();
    for (const auto& seat : seats_) {
      seat->waiting = 0;
      seat->worker.release();
    }
  }

  EvaluatorStats stats() const override {
    EvaluatorStats stats;
    for (const auto& seat : seats_) {
      stats.leaves += seat->worker.leaves();
      stats.steps += seat->worker.steps();
    }
    return stats;
  }

 private:
  // One thread's worker, and the ring of leaves that the thread has submitted.
  struct alignas(kCacheLine) Seat {
    explicit Seat(CpuScene<M>& scene) : worker(scene) {}

    CpuWorker<M> worker;
    std::vector<LeafRequest> queue;
    std::size_t oldest = 0;
    std::size_t waiting = 0;
  };

  static std::size_t queue_size(const EvaluatorOptions& options, std::size_t threads) {
    return std::max<std::size_t>(1, (options.in_flight + threads - 1) / threads);
  }

  CpuScene<M> scene_;
  std::size_t queue_size_;  // of each thread
  std::vector<typename M::State> states_;
  std::vector<std::unique_ptr<Seat>> seats_;
};

}  // namespace hypgen
