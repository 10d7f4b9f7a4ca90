// SPDX-License-Identifier: Apache-2.0
// Expands leaves on a device and on the host: each leaf where the thread that asks has it sooner.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "hypgen/leaves/cpu_scene.hpp"
#include "hypgen/leaves/cpu_worker.hpp"
#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/memory/chunk_pool.hpp"

namespace hypgen {

// A device takes about as long for one rollout as for thousands. So it pays for large leaves and for many leaves
// at once, and a core for a few small ones. Both give the same rows, bit for bit.
//
// A leaf below one that the host expanded is the host's too: it is no larger. Where the device expanded the leaf
// above, the host simulates that leaf's members anew.
template <class M>
class HybridEvaluator final : public LeafEvaluator {
 public:
  // `device` was made with the same params and half of the memory.
  HybridEvaluator(const typename M::Params& params, const EvaluatorOptions& options,
                  std::unique_ptr<LeafEvaluator> device)
      : device_(std::move(device)), scene_(params, half(options)), states_(options.max_scenarios) {
    const std::size_t share =
        std::max<std::size_t>(1, (options.in_flight + scene_.threads - 1) / scene_.threads);
    for (std::size_t i = 0; i < scene_.threads; ++i) seats_.push_back(std::make_unique<Seat>(scene_, share));
    seats_[0]->worker.learn_pauses();
  }

  std::size_t threads() const override { return std::min(scene_.threads, device_->threads()); }
  std::size_t lanes() const override { return device_->lanes(); }
  void attach(std::size_t thread) override { device_->attach(thread); }

  RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) override {
    release();
    const RootResult result = device_->begin_search(root, setup);
    if (result.status != Status::kOk) return result;
    scene_.setup = setup;
    for (const auto& seat : seats_) seat->worker.begin_search(root.first());
    typename M::History history{};
    root.copy_to(scene_.fixed.data(), states_.data());
    root.copy_history_to(history);
    if (seats_[0]->worker.keep_root(states_, root.size(), history)) return result;
    return {Status::kMemoryFull, {}, -1};
  }

  std::size_t submit(std::size_t thread, Span<const LeafRequest> requests) override {
    Seat& seat = *seats_[thread];
    for (std::size_t i = 0; i < requests.size(); ++i) {
      LeafRequest request = requests[i];
      if (request.parent != kNoHandle) request.parent = on_device(request.parent).handle;
      if (seat.waiting == seat.queue.size() || device_->submit(thread, {&request, 1}) == 0) return i;
      seat.queue[(seat.oldest + seat.waiting) % seat.queue.size()] = {requests[i], Clock::now()};
      ++seat.waiting;
    }
    return requests.size();
  }

  bool poll(std::size_t thread, LeafResult& result) override {
    if (!device_->poll(thread, result)) return false;
    Seat& seat = *seats_[thread];
    const Sent& sent = seat.queue[seat.oldest];
    seat.device_seconds.add(std::chrono::duration<double>(Clock::now() - sent.time).count());
    seat.oldest = (seat.oldest + 1) % seat.queue.size();
    --seat.waiting;
    if (result.status == Status::kOk) note_node(seat, sent.request, result);
    return true;
  }

  bool expand_here(std::size_t thread, const LeafRequest& request, std::size_t at_once,
                   LeafResult& result) override {
    Seat& seat = *seats_[thread];
    LeafRequest here = request;
    if (request.parent & kOnDevice) {
      if (!is_sooner_here(seat, members_in(request), at_once)) return false;
      here.parent = on_host(seat.worker, on_device(request.parent)).units;
      if (here.parent == 0) return false;
    }
    const Clock::time_point start = Clock::now();
    result = seat.worker.expand(here);
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    seat.member_seconds.add(seconds / members_in(request));
    return true;
  }

  void release() override {
    scene_.pool.reset();
    for (const auto& seat : seats_) seat->release();
    device_->release();
  }

  EvaluatorStats stats() const override {
    EvaluatorStats stats = device_->stats();
    for (const auto& seat : seats_) {
      stats.host_leaves += seat->worker.leaves();
      stats.steps += seat->worker.steps();
    }
    return stats;
  }

  std::string problem() const override { return device_->problem(); }
  bool is_stuck() override { return device_->is_stuck(); }

 private:
  static EvaluatorOptions half(EvaluatorOptions options) {
    options.memory_bytes /= 2;
    return options;
  }

  // A handle of this evaluator is the place of a CpuNode, or with this bit that of a DeviceNode.
  static constexpr std::uint64_t kOnDevice = std::uint64_t{1} << 32;
  static constexpr std::uint32_t kFirstCount = 16;  // the largest leaf that the host tries first

  // A node that the device expanded, and how it came about. The thread that reads the device's result writes it,
  // and publishes it with the tree's node.
  struct DeviceNode {
    std::uint64_t handle;  // of the device
    LeafRequest request;   // with the parent's handle here
    // The place of the node's members on the host; 0: they are not there. Any thread that needs them stores it
    // (release; two may store different places with equal contents) and reads it (acquire).
    std::atomic<std::uint32_t> host;
  };

  // A leaf that the device has.
  struct Sent {
    LeafRequest request;
    Clock::time_point time{};
  };

  // The mean of what was measured lately; 0: nothing was.
  struct RecentMean {
    double value = 0.0;
    void add(double next) { value = value > 0.0 ? value + kWeight * (next - value) : next; }
    // An estimate that nothing renews shrinks, so that what it speaks against is tried again.
    void fade() { value *= 1.0 - kFading; }

   private:
    static constexpr double kWeight = 0.1, kFading = 1e-3;
  };

  // What one thread has.
  struct alignas(kCacheLine) Seat {
    Seat(CpuScene<M>& scene, std::size_t in_flight) : worker(scene), nodes(scene.pool), queue(in_flight) {}

    void release() {
      worker.release();
      nodes.reset();
      waiting = 0;
    }

    CpuWorker<M> worker;
    PoolCursor nodes;         // for DeviceNodes
    std::vector<Sent> queue;  // a ring
    std::size_t oldest = 0;
    std::size_t waiting = 0;
    RecentMean device_seconds;  // until the device's answer to a leaf
    RecentMean member_seconds;  // for a scenario of a leaf on the host
  };

  DeviceNode& on_device(std::uint64_t handle) const {
    return scene_.pool[Ref<DeviceNode>{static_cast<std::uint32_t>(handle)}];
  }

  // Keeps how the node of a result came about, and gives the result the node's handle here.
  void note_node(Seat& seat, const LeafRequest& request, LeafResult& result) {
    const Ref<DeviceNode> place = seat.nodes.template take<DeviceNode>();
    if (!place) {
      result.status = Status::kMemoryFull;
      return;
    }
    const std::uint32_t host = request.parent == kNoHandle ? scene_.root.units : 0;
    new (&scene_.pool[place]) DeviceNode{result.handle, request, {host}};
    result.handle = kOnDevice | place.units;
  }

  // The node's members on the host; none if there is no room for them. A parent of a device's node is the
  // device's too.
  Ref<CpuNode<M>> on_host(CpuWorker<M>& worker, DeviceNode& node) {
    const std::uint32_t known = node.host.load(std::memory_order_acquire);
    if (known != 0) return {known};
    LeafRequest request = node.request;
    request.parent = on_host(worker, on_device(request.parent)).units;
    const Ref<CpuNode<M>> made = request.parent == 0 ? Ref<CpuNode<M>>{} : worker.keep_child(request);
    node.host.store(made.units, std::memory_order_release);
    return made;
  }

  // About how many members a leaf has.
  std::uint32_t members_in(const LeafRequest& request) const {
    return scene_.setup.weighted ? members_for(request.count, 1, UINT32_MAX) : request.count;
  }

  bool is_sooner_here(Seat& seat, std::uint32_t count, std::size_t at_once) const {
    if (seat.device_seconds.value == 0.0) return false;
    if (seat.member_seconds.value == 0.0) return count <= kFirstCount;
    const bool is_sooner =
        count * seat.member_seconds.value < seat.device_seconds.value / static_cast<double>(at_once);
    (is_sooner ? seat.device_seconds : seat.member_seconds).fade();
    return is_sooner;
  }

  std::unique_ptr<LeafEvaluator> device_;
  CpuScene<M> scene_;
  std::vector<typename M::State> states_;  // of the root
  std::vector<std::unique_ptr<Seat>> seats_;
};

}  // namespace hypgen
