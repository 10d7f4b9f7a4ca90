// SPDX-License-Identifier: Apache-2.0
// An evaluator with the CPU's results that answers when it likes, or not at all.
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "hypgen/leaves/leaf_evaluator.hpp"

namespace hypgen::testing {

struct Mischief {
  unsigned seed = 0;                  // of the order of work, of delays and of how many leaves are taken
  std::uint64_t leaves = UINT64_MAX;  // after these, each leaf has `status`
  Status status = Status::kOk;
  bool falls_silent = false;  // after `leaves` there are no answers at all
};

// Works on a thread's queued leaves in any order and yields them in that of submission.
class MockEvaluator final : public LeafEvaluator {
 public:
  MockEvaluator(std::unique_ptr<LeafEvaluator> inner, const Mischief& mischief)
      : inner_(std::move(inner)), mischief_(mischief), seats_(inner_->threads()) {
    for (std::size_t i = 0; i < seats_.size(); ++i) {
      seats_[i].random.seed(mischief.seed + static_cast<unsigned>(i));
    }
  }

  std::size_t threads() const override { return inner_->threads(); }
  void attach(std::size_t thread) override { inner_->attach(thread); }

  RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) override {
    for (Seat& seat : seats_) seat.queue.clear();
    return inner_->begin_search(root, setup);
  }

  std::size_t submit(std::size_t thread, Span<const LeafRequest> requests) override {
    Seat& seat = seats_[thread];
    const std::size_t count = seat.random() % (requests.size() + 1);
    for (std::size_t i = 0; i < count; ++i) seat.queue.push_back({requests[i], {}, false});
    return count;
  }

  bool poll(std::size_t thread, LeafResult& result) override {
    Seat& seat = seats_[thread];
    if (seat.queue.empty()) return false;
    work(thread, seat.queue[seat.random() % seat.queue.size()]);
    const bool is_late = seat.random() % 3 == 0;
    if (!seat.queue.front().done || is_late) return false;
    if (yielded_.load() >= mischief_.leaves && mischief_.falls_silent) return false;
    result = seat.queue.front().result;
    seat.queue.pop_front();
    if (yielded_.fetch_add(1) >= mischief_.leaves) result.status = mischief_.status;
    return true;
  }

  void release() override {
    for (Seat& seat : seats_) seat.queue.clear();
    inner_->release();
  }

 private:
  struct Pending {
    LeafRequest request;
    LeafResult result;
    bool done;
  };
  struct Seat {
    std::mt19937 random;
    std::deque<Pending> queue;
  };

  void work(std::size_t thread, Pending& leaf) {
    if (leaf.done) return;
    inner_->submit(thread, {&leaf.request, 1});
    inner_->poll(thread, leaf.result);
    leaf.done = true;
  }

  std::unique_ptr<LeafEvaluator> inner_;
  Mischief mischief_;
  std::vector<Seat> seats_;  // by thread
  std::atomic<std::uint64_t> yielded_{0};
};

}  // namespace hypgen::testing
