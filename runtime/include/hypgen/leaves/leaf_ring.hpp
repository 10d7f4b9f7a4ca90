// Leaves of several threads on their way to one evaluator and back, without a lock.
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

// One thread's leaves. The thread submits and reads; the driver, one at a time, takes and answers, in any
// order.
class LeafRing {
 public:
  explicit LeafRing(std::size_t size) : entries_(size) {}

  // Only while neither side is at work.
  void reset() {
    submitted_.store(0, std::memory_order_relaxed);
    read_.store(0, std::memory_order_relaxed);
    taken_.store(0, std::memory_order_relaxed);
    answered_ = 0;
  }

  // The thread's side --------------------------------------------------------------------------------

  // False: full.
  bool submit(const LeafRequest& request) {
    const std::uint64_t place = submitted_.load(std::memory_order_relaxed);
    if (place - read_.load(std::memory_order_relaxed) == entries_.size()) return false;
    entry(place).request = request;
    entry(place).is_answered.store(false, std::memory_order_relaxed);
    submitted_.store(place + 1, std::memory_order_release);
    return true;
  }

  // The oldest leaf's result; false if it is not there yet, or there is no leaf.
  bool read(LeafResult& result) {
    const std::uint64_t place = read_.load(std::memory_order_relaxed);
    if (place == submitted_.load(std::memory_order_relaxed)) return false;
    if (!entry(place).is_answered.load(std::memory_order_acquire)) return false;
    result = entry(place).result;
    read_.store(place + 1, std::memory_order_relaxed);
    return true;
  }

  // Whether so many of the ring's leaves wait that a batch is worth while, as far as this thread can tell.
  bool is_half_waiting() const {
    const std::uint64_t waiting =
        submitted_.load(std::memory_order_relaxed) - taken_.load(std::memory_order_relaxed);
    return 2 * waiting >= entries_.size();
  }

  // The driver's side --------------------------------------------------------------------------------

  std::size_t waiting() const {
    return static_cast<std::size_t>(submitted_.load(std::memory_order_acquire) -
                                    taken_.load(std::memory_order_relaxed));
  }

  // Whether the thread still has a result to read; a hint.
  bool has_unread() const { return answered_ != read_.load(std::memory_order_relaxed); }

  // The place of the oldest leaf that waits, which is then taken.
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
    LeafRequest request{};                 // by the thread, before `submitted_`
    LeafResult result{};                   // by the driver, before `is_answered`
    std::atomic<bool> is_answered{false};  // false by the thread before `submitted_`, then true by the driver
  };

  Entry& entry(std::uint64_t place) { return entries_[place % entries_.size()]; }

  std::vector<Entry> entries_;
  // Written by the thread. The driver acquires `submitted_` and with it the requests.
  alignas(kCacheLine) std::atomic<std::uint64_t> submitted_{0};
  std::atomic<std::uint64_t> read_{0};
  // Written by the driver; the thread takes a hint from `taken_`.
  alignas(kCacheLine) std::atomic<std::uint64_t> taken_{0};
  std::uint64_t answered_ = 0;
};

// A ring for each thread, and who serves them all: the thread that has the role of the driver.
class LeafRings {
 public:
  // A leaf in flight.
  struct Place {
    std::size_t thread;
    std::uint64_t number;
  };

  LeafRings(std::size_t threads, std::size_t in_flight) {
    const std::size_t share = std::max<std::size_t>(1, (in_flight + threads - 1) / threads);
    for (std::size_t i = 0; i < threads; ++i) rings_.push_back(std::make_unique<LeafRing>(share));
  }

  // Only while no thread is at work.
  void reset() {
    for (const auto& ring : rings_) ring->reset();
  }

  std::size_t threads() const { return rings_.size(); }
  LeafRing& operator[](std::size_t thread) { return *rings_[thread]; }

  // Takes the role of the driver if nobody has it. What the last driver wrote is then there to be read.
  bool start_driving() {
    return !is_driven_.load(std::memory_order_relaxed) &&
           !is_driven_.exchange(true, std::memory_order_acquire);
  }
  void stop_driving() { is_driven_.store(false, std::memory_order_release); }

  // The thread's oldest leaf's result; false if it is not there yet. A thread that does not find its own
  // calls `drive` for all, if nobody does. So does one that finds it while half of its ring waits: otherwise
  // the device would be idle while a thread reads a whole batch.
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

  // The driver's -------------------------------------------------------------------------------------

  std::size_t waiting() const {
    std::size_t count = 0;
    for (const auto& ring : rings_) count += ring->waiting();
    return count;
  }

  bool has_unread() const {
    return std::any_of(rings_.begin(), rings_.end(), [](const auto& ring) { return ring->has_unread(); });
  }

  // Offers leaves that wait, one of each thread in turn, until none waits or `accept(place, request)` is
  // false: that one still waits. Begins one thread further than the time before.
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
  std::size_t first_ = 0;  // the driver's
  alignas(kCacheLine) std::atomic<bool> is_driven_{false};
};

}  // namespace hypgen
