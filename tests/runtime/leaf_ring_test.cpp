// SPDX-License-Identifier: Apache-2.0
#include "hypgen/leaves/leaf_ring.hpp"

#include <gtest/gtest.h>

#include <random>
#include <thread>
#include <vector>

namespace hypgen {
namespace {

LeafRequest request(std::uint32_t ticket) { return {ticket, 7, 1, 2, ticket + 1, 3, {}}; }

LeafResult answer_to(const LeafRequest& request) {
  return {request.ticket, Status::kOk, request.parent + request.ticket, request.count, {}, {}, {}};
}

std::vector<std::uint32_t> take_all(LeafRings& rings, std::size_t most) {
  std::vector<std::uint32_t> tickets;
  rings.take_in_turn([&](const LeafRings::Place&, const LeafRequest& request) {
    if (tickets.size() == most) return false;
    tickets.push_back(request.ticket);
    return true;
  });
  return tickets;
}

TEST(LeafRing, IsFullUntilResultsAreRead) {
  LeafRing ring(2);
  LeafResult result{};
  EXPECT_FALSE(ring.read(result));
  EXPECT_TRUE(ring.submit(request(0)));
  EXPECT_TRUE(ring.is_half_waiting());
  EXPECT_TRUE(ring.submit(request(1)));
  EXPECT_FALSE(ring.submit(request(2)));
  EXPECT_EQ(ring.waiting(), 2U);
  ring.take();
  ring.take();
  EXPECT_EQ(ring.waiting(), 0U);
  EXPECT_FALSE(ring.is_half_waiting());
  ring.answer(1, answer_to(ring.request(1)));
  EXPECT_FALSE(ring.read(result));  // the older one is not there yet
  ring.answer(0, answer_to(ring.request(0)));
  EXPECT_TRUE(ring.has_unread());
  for (std::uint32_t ticket = 0; ticket < 2; ++ticket) {
    ASSERT_TRUE(ring.read(result));
    EXPECT_EQ(result.ticket, ticket);
    EXPECT_EQ(result.handle, 7U + ticket);
  }
  EXPECT_FALSE(ring.has_unread());
  EXPECT_TRUE(ring.submit(request(2)));
}

TEST(LeafRings, ThreadsTakeTurns) {
  LeafRings rings(3, 12);
  for (std::uint32_t i = 0; i < 4; ++i) rings[0].submit(request(i));
  for (std::uint32_t i = 0; i < 2; ++i) rings[2].submit(request(20 + i));
  EXPECT_EQ(rings.waiting(), 6U);
  EXPECT_EQ(take_all(rings, 3), (std::vector<std::uint32_t>{20, 0, 21}));
  EXPECT_EQ(take_all(rings, 1), (std::vector<std::uint32_t>{1}));
  EXPECT_EQ(take_all(rings, 9), (std::vector<std::uint32_t>{2, 3}));
  EXPECT_EQ(rings.waiting(), 0U);
  rings.reset();
  rings[0].submit(request(5));
  EXPECT_EQ(take_all(rings, 9), (std::vector<std::uint32_t>{5}));
}

TEST(LeafRings, HaveOneDriver) {
  LeafRings rings(2, 4);
  EXPECT_TRUE(rings.start_driving());
  EXPECT_FALSE(rings.start_driving());
  rings.stop_driving();
  EXPECT_TRUE(rings.start_driving());
}

// What an evaluator does with the rings, without a device: leaves are answered in random order, now or later.
// All but the rings is plain: under ThreadSanitizer two drivers at a time would be found.
class Device {
 public:
  Device(std::size_t threads, std::size_t in_flight) : rings_(threads, in_flight) {}

  bool submit(std::size_t thread, const LeafRequest& request) { return rings_[thread].submit(request); }

  bool poll(std::size_t thread, LeafResult& result) {
    return rings_.poll(thread, result, [this] { drive(); });
  }

  std::uint64_t answered() const { return answered_; }

 private:
  void drive() {
    rings_.take_in_turn([&](const LeafRings::Place& place, const LeafRequest&) {
      if (places_.size() >= 4 && random_() % 8 == 0) return false;
      places_.push_back(place);
      return true;
    });
    while (!places_.empty() && random_() % 4 != 0) {
      std::swap(places_[random_() % places_.size()], places_.back());
      rings_.answer(places_.back(), answer_to(rings_.request(places_.back())));
      places_.pop_back();
      ++answered_;
    }
  }

  LeafRings rings_;
  std::vector<LeafRings::Place> places_;
  std::mt19937 random_{1};
  std::uint64_t answered_ = 0;
};

// Submits `leaves` as they fit and checks what comes back, with pauses now and then.
void search(Device& device, std::size_t thread, std::uint32_t leaves, bool& is_right) {
  std::mt19937 random(static_cast<unsigned>(thread));
  std::uint32_t submitted = 0, received = 0;
  is_right = true;
  while (received < leaves) {
    while (submitted < leaves && random() % 4 != 0 && device.submit(thread, request(submitted))) ++submitted;
    LeafResult result{};
    if (device.poll(thread, result)) {
      is_right &= result.ticket == received && result.handle == 7U + received &&
                  result.count == received + 1 && received < submitted;
      ++received;
    } else {
      std::this_thread::yield();
    }
    if (random() % 1000 == 0) std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
}

TEST(LeafRings, EachThreadGetsItsLeavesInOrder) {
  constexpr std::size_t kThreads = 4;
  constexpr std::uint32_t kLeaves = 20000;
  for (const std::size_t in_flight : {std::size_t{1}, std::size_t{64}}) {
    Device device(kThreads, in_flight);
    bool is_right[kThreads] = {};
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < kThreads; ++t) {
      threads.emplace_back([&, t] { search(device, t, kLeaves, is_right[t]); });
    }
    for (std::thread& thread : threads) thread.join();
    for (const bool right : is_right) EXPECT_TRUE(right);
    EXPECT_EQ(device.answered(), kThreads * kLeaves);
  }
}

}  // namespace
}  // namespace hypgen
