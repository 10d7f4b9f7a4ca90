// An evaluator with the CPU's results that answers when it likes, or not at all.
#pragma once

#include <deque>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "hypgen/leaf_evaluator.hpp"

namespace hypgen::testing {

struct Mischief {
  unsigned seed = 0;                  // of the order of work, of delays and of how many leaves are taken
  std::uint64_t leaves = UINT64_MAX;  // after these, each leaf has `status`
  Status status = Status::kOk;
  bool falls_silent = false;  // after `leaves` there are no answers at all
};

// Works on queued leaves in any order and yields them in that of submission.
class MockEvaluator final : public LeafEvaluator {
 public:
  MockEvaluator(std::unique_ptr<LeafEvaluator> inner, const Mischief& mischief)
      : inner_(std::move(inner)), mischief_(mischief), random_(mischief.seed) {}

  RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) override {
    queue_.clear();
    return inner_->begin_search(root, setup);
  }

  std::size_t submit(Span<const LeafRequest> requests) override {
    const std::size_t count = random_() % (requests.size() + 1);
    for (std::size_t i = 0; i < count; ++i) queue_.push_back({requests[i], {}, {}, false});
    return count;
  }

  bool poll(LeafResult& result) override {
    if (queue_.empty()) return false;
    work(queue_[random_() % queue_.size()]);
    const bool is_late = random_() % 3 == 0;
    if (!queue_.front().done || is_late) return false;
    if (yielded_ >= mischief_.leaves && mischief_.falls_silent) return false;
    shown_ = std::move(queue_.front());
    queue_.pop_front();
    result = shown_.result;
    result.actions = shown_.actions;
    if (yielded_++ >= mischief_.leaves) result.status = mischief_.status;
    return true;
  }

  void release() override {
    queue_.clear();
    inner_->release();
  }

 private:
  struct Pending {
    LeafRequest request;
    LeafResult result;
    std::vector<ActionRow> actions;
    bool done;
  };

  void work(Pending& leaf) {
    if (leaf.done) return;
    inner_->submit({&leaf.request, 1});
    inner_->poll(leaf.result);
    leaf.actions.assign(leaf.result.actions.begin(), leaf.result.actions.end());
    leaf.done = true;
  }

  std::unique_ptr<LeafEvaluator> inner_;
  Mischief mischief_;
  std::mt19937 random_;
  std::deque<Pending> queue_;
  Pending shown_{};
  std::uint64_t yielded_ = 0;
};

}  // namespace hypgen::testing
