// SPDX-License-Identifier: Apache-2.0
// Searches whose leaves go through rings to one driver at a time, as to a GPU; here it has the CPU's results.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "hypgen/leaves/leaf_ring.hpp"
#include "test_solvers.hpp"

namespace hypgen::testing {
namespace {

// Leaves are expanded in any order, now or later. All but the rings is plain, the inner evaluator's only
// thread included: whoever drives has it to himself.
class RingEvaluator final : public LeafEvaluator {
 public:
  // It works once in each `latency`.
  RingEvaluator(std::unique_ptr<LeafEvaluator> inner, const PlannerOptions& options,
                Clock::duration latency = {})
      : inner_(std::move(inner)), rings_(options.threads, options.in_flight), latency_(latency) {
    random_.seed(static_cast<unsigned>(options.seed));
  }

  std::size_t threads() const override { return rings_.threads(); }

  RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) override {
    release();
    return inner_->begin_search(root, setup);
  }

  std::size_t submit(std::size_t thread, Span<const LeafRequest> requests) override {
    std::size_t taken = 0;
    while (taken < requests.size() && rings_[thread].submit(requests[taken])) ++taken;
    return taken;
  }

  bool poll(std::size_t thread, LeafResult& result) override {
    return rings_.poll(thread, result, [this] { drive(); });
  }

  void release() override {
    rings_.reset();
    running_.clear();
    inner_->release();
  }

 private:
  void drive() {
    if (Clock::now() < next_) return;
    next_ = Clock::now() + latency_;
    const std::size_t most = running_.size() + random_() % 8;
    rings_.take_in_turn([&](const LeafRings::Place& place, const LeafRequest&) {
      if (running_.size() >= most) return false;
      running_.push_back(place);
      return true;
    });
    while (!running_.empty() && random_() % 5 != 0) {
      std::swap(running_[random_() % running_.size()], running_.back());
      const LeafRequest& request = rings_.request(running_.back());
      LeafResult result{};
      inner_->submit(0, {&request, 1});
      inner_->poll(0, result);
      rings_.answer(running_.back(), result);
      running_.pop_back();
    }
  }

  std::unique_ptr<LeafEvaluator> inner_;
  LeafRings rings_;
  std::vector<LeafRings::Place> running_;
  Clock::duration latency_;
  Clock::time_point next_{};
  std::mt19937 random_;
};

Decision plan(const PlannerOptions& options) {
  const Solver solver(rock_sample_descriptor<4, 3>(), options);
  PlannerOptions one_thread = options;
  one_thread.threads = 1;
  auto inner = solver.instance->make_evaluator(evaluator_options(one_thread, solver.model));
  Planner planner(std::make_unique<RingEvaluator>(std::move(inner), options), solver.model, options);
  planner.prepare(*solver.belief);
  return checked_plan(planner, *solver.belief, 0);
}

TEST(RingSearch, OneThreadsTreeIsTheSame) {
  PlannerOptions options = trials(300);
  options.in_flight = 16;
  options.signature = true;
  const std::uint64_t expected = Solver(rock_sample_descriptor<4, 3>(), options).plan().signature;
  EXPECT_EQ(plan(options).signature, expected);
}

TEST(RingSearch, SeveralThreadsDoAllTrials) {
  PlannerOptions options = trials(500);
  options.mode = Mode::kParallel;
  for (const std::size_t threads : {2, 4, 16}) {
    options.seed = options.threads = threads;
    options.in_flight = 4 * threads;
    const Decision decision = plan(options);
    EXPECT_EQ(decision.status, Status::kTrialLimit);
    EXPECT_EQ(decision.trials, 500U);
    EXPECT_LE(decision.lower, decision.upper);
  }
}

TEST(RingSearch, SeveralThreadsEndAtADeadline) {
  PlannerOptions options = trials(UINT64_MAX);
  options.mode = Mode::kParallel;
  options.threads = 4;
  options.in_flight = 64;
  options.time_limit = 0.02;
  options.gap = -1.0;
  const Decision decision = plan(options);
  EXPECT_TRUE(decision.status == Status::kDeadline || decision.status == Status::kMemoryFull);
  EXPECT_GE(decision.action, 0);
}

// A search whose leaves go to a slow device or to the host.
class HybridSearch {
 public:
  explicit HybridSearch(const PlannerOptions& options) : solver_(rock_sample_descriptor<4, 3>(), options) {
    PlannerOptions one_thread = options;
    one_thread.threads = 1;
    auto inner = solver_.instance->make_evaluator(evaluator_options(one_thread, solver_.model));
    auto device = std::make_unique<RingEvaluator>(std::move(inner), options, kLatency);
    auto both = solver_.instance->add_host(std::move(device), evaluator_options(options, solver_.model));
    planner_ = std::make_unique<Planner>(std::move(both), solver_.model, options);
    planner_->prepare(*solver_.belief);
  }

  Decision plan(int step) { return checked_plan(*planner_, *solver_.belief, step); }
  std::uint64_t host_leaves() { return planner_->evaluator_stats().host_leaves; }

 private:
  static constexpr std::chrono::milliseconds kLatency{1};

  Solver solver_;
  std::unique_ptr<Planner> planner_;
};

TEST(HybridSearch, OneTrialAtATimeGivesTheSameTreeWhereverItsLeavesAreExpanded) {
  PlannerOptions options = trials(300);
  options.signature = true;
  HybridSearch hybrid(options);
  const Solver plain(rock_sample_descriptor<4, 3>(), options);
  Planner planner(plain.instance->make_evaluator(evaluator_options(options, plain.model)), plain.model,
                  options);
  planner.prepare(*plain.belief);
  for (int step = 0; step < 3; ++step) {
    EXPECT_EQ(hybrid.plan(step).signature, checked_plan(planner, *plain.belief, step).signature);
  }
  EXPECT_GT(hybrid.host_leaves(), 0U);
}

TEST(HybridSearch, SeveralThreadsDoAllTrials) {
  PlannerOptions options = trials(500);
  options.mode = Mode::kHyp;
  for (const std::size_t threads : {2, 4, 16}) {
    options.seed = options.threads = threads;
    options.in_flight = 4 * threads;
    HybridSearch hybrid(options);
    for (int step = 0; step < 3; ++step) {
      const Decision decision = hybrid.plan(step);
      EXPECT_EQ(decision.status, Status::kTrialLimit);
      EXPECT_EQ(decision.trials, 500U);
      EXPECT_LE(decision.lower, decision.upper);
    }
    EXPECT_GT(hybrid.host_leaves(), 0U);
  }
}

TEST(HybridSearch, SeveralThreadsEndAtADeadline) {
  PlannerOptions options = trials(UINT64_MAX);
  options.mode = Mode::kHyp;
  options.threads = 4;
  options.in_flight = 64;
  options.time_limit = 0.02;
  options.gap = -1.0;
  const Decision decision = HybridSearch(options).plan(0);
  EXPECT_TRUE(decision.status == Status::kDeadline || decision.status == Status::kMemoryFull);
  EXPECT_GE(decision.action, 0);
}

}  // namespace
}  // namespace hypgen::testing
