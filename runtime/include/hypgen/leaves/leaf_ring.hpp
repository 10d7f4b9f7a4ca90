// SPDX-License-Identifier: Apache-2.0
// Queues of leaves between the threads of a search and a device, without a lock.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/memory/chunk_pool.hpp"

namespace hypgen {

// The queue of one thread. The thread submits requests and reads results in that order. The driver takes
// requests in order and answers them in any order. At most one thread is the driver at a time (LeafRings).
class LeafRing {
 public:
  explicit LeafRing(std::size_t size) : entries_(size) {}

  // Empties the ring. Neither side is at work.
  void reset() {
    submitted_.store(0, std::memory_order_relaxed);
    read_.store(0, std::memory_order_relaxed);
    taken_.store(0, std::memory_order_relaxed);
    answered_ = 0;
  }

  // The thread's calls --------------------------------------------------------------------------------

  // Adds a request; false if the ring is full.
  bool submit(const LeafRequest& request) {
    const std::uint64_t place = submitted_.load(std::memory_order_relaxed);
    if (place - read_.load(std::memory_order_relaxed) == entries_.size()) return false;
    entry(place).request = request;
    entry(place).is_answered.store(false, std::memory_order_relaxed);
    submitted_.store(place + 1, std::memory_order_release);
    return true;
  }

  // Gives the oldest request's result; false if it is not answered, or there is no request.
  bool read(LeafResult& result) {
    const std::uint64_t place = read_.load(std::memory_order_relaxed);
    if (place == submitted_.load(std::memory_order_relaxed)) return false;
    if (!entry(place).is_answered.load(std::memory_order_acquire)) return false;
    result = entry(place).result;
    read_.store(place + 1, std::memory_order_relaxed);
    return true;
  }

  // Whether half of the ring's requests wait to be taken, as far as this thread can tell: enough for a batch.
  bool is_half_waiting() const {
    const std::uint64_t waiting =
        submitted_.load(std::memory_order_relaxed) - taken_.load(std::memory_order_relaxed);
    return 2 * waiting >= entries_.size();
  }

  // The driver's calls --------------------------------------------------------------------------------

  std::size_t waiting() const {
    return static_cast<std::size_t>(submitted_.load(std::memory_order_acquire) -
                                    taken_.load(std::memory_order_relaxed));
  }

  // Whether the thread has results to read, as far as the driver can tell.
  bool has_unread() const { return answered_ != read_.load(std::memory_order_relaxed); }

  // `next` gives the place of the oldest request that waits. `take` takes it.
  std::uint64_t next() const { return taken_.load(std::memory_order_relaxed); }
  void take() { taken_.store(next() + 1, std::memory_order_relaxed); }

  const LeafRequest& request(std::uint64_t place) const { return entries_[place % entries_.size()].request; }

  void answer(std::uint64_t place, const LeafResult& result) {
    entry(place).result = result;
    ++answered_;
    entry(place).is_answered.store(true, std::memory_order_release);
  }

 private:
  struct alignas(kCacheLine) Entry {
    LeafRequest request{};  // the thread writes it before it stores `submitted_`
    LeafResult result{};    // the driver writes it before it stores `is_answered`
    // The thread stores false before it stores `submitted_`: relaxed. The driver stores true: release. The
    // thread reads it: acquire.
    std::atomic<bool> is_answered{false};
  };

  Entry& entry(std::uint64_t place) { return entries_[place % entries_.size()]; }

  std::vector<Entry> entries_;
  // Requests submitted and results read so far. The thread writes both: `submitted_` with release, `read_`
  // relaxed. The driver acquires `submitted_`, and with it the requests; it reads `read_` as a hint.
  alignas(kCacheLine) std::atomic<std::uint64_t> submitted_{0};
  std::atomic<std::uint64_t> read_{0};
  // Requests taken and answered so far. The driver writes both, `taken_` relaxed. The thread reads `taken_`
  // as a hint. The next driver sees both, because it acquires `LeafRings::is_driven_`.
  alignas(kCacheLine) std::atomic<std::uint64_t> taken_{0};
  std::uint64_t answered_ = 0;
};

// A ring for each thread. One thread at a time has the role of the driver, which serves all rings.
class LeafRings {
 public:
  // The place of a request in flight.
  struct Place {
    std::size_t thread;
    std::uint64_t number;
  };

  LeafRings(std::size_t threads, std::size_t in_flight) {
    const std::size_t share = std::max<std::size_t>(1, (in_flight + threads - 1) / threads);
    for (std::size_t i = 0; i < threads; ++i) rings_.push_back(std::make_unique<LeafRing>(share));
  }

  // Empties all rings. No thread is at work.
  void reset() {
    for (const auto& ring : rings_) ring->reset();
  }

  std::size_t threads() const { return rings_.size(); }
  LeafRing& operator[](std::size_t thread) { return *rings_[thread]; }

  // Takes the role of the driver if no thread has it. The new driver sees what the last one wrote.
  bool start_driving() {
    return !is_driven_.load(std::memory_order_relaxed) &&
           !is_driven_.exchange(true, std::memory_order_acquire);
  }
  void stop_driving() { is_driven_.store(false, std::memory_order_release); }

  // Gives the result of the thread's oldest request; false if it is not answered. A thread whose result is
  // missing becomes the driver, if there is none, and calls `drive`. So does a thread that has a result while
  // half of its ring waits: otherwise the device would be idle while that thread reads a whole batch.
  template <class Drive>
  bool poll(std::size_t thread, LeafResult& result, const Drive& drive) {
    LeafRing& ring = *rings_[thread];
    const bool found = ring.read(result);
    if (found && !ring.is_half_waiting()) return true;
    if (start_driving()) {
      drive();
      stop_driving();
    }
    return found || ring.read(result);
  }

  // The driver's calls -------------------------------------------------------------------------------------

  std::size_t waiting() const {
    std::size_t count = 0;
    for (const auto& ring : rings_) count += ring->waiting();
    return count;
  }

  bool has_unread() const {
    return std::any_of(rings_.begin(), rings_.end(), [](const auto& ring) { return ring->has_unread(); });
  }

  // Offers requests that wait to `accept(place, request)`, one of each thread in turn, until none waits or
  // `accept` gives false. That request goes on waiting. Each call begins one thread further than the last.
  template <class Accept>
  void take_in_turn(const Accept& accept) {
    first_ = (first_ + 1) % threads();
    for (bool took = true; took;) {
      took = false;
      for (std::size_t i = 0; i < threads(); ++i) {
        const std::size_t thread = (first_ + i) % threads();
        LeafRing& ring = *rings_[thread];
        if (ring.waiting() == 0) continue;
        if (!accept(Place{thread, ring.next()}, ring.request(ring.next()))) return;
        ring.take();
        took = true;
      }
    }
  }

  const LeafRequest& request(const Place& place) const { return rings_[place.thread]->request(place.number); }
  void answer(const Place& place, const LeafResult& result) {
    rings_[place.thread]->answer(place.number, result);
  }

 private:
  std::vector<std::unique_ptr<LeafRing>> rings_;
  std::size_t first_ = 0;  // the thread that the last turn began with; only the driver uses it
  // Whether a thread is the driver. It sets it with acquire at the start and clears it with release at the
  // end.
  alignas(kCacheLine) std::atomic<bool> is_driven_{false};
};

}  // namespace hypgen
