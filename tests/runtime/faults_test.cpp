// SPDX-License-Identifier: Apache-2.0
// What several threads make of settings that leave them little, and of evaluators that fail: a legal action,
// and a status that says why.
#include <gtest/gtest.h>

#include <set>

#include "hypgen/solver/model_instance.hpp"
#include "mock_evaluator.hpp"
#include "test_solvers.hpp"

namespace hypgen::testing {
namespace {

PlannerOptions by_threads(std::size_t threads, std::uint64_t count = UINT64_MAX) {
  PlannerOptions options = trials(count);
  options.mode = Mode::kParallel;
  options.threads = options.in_flight = threads;
  return options;
}

// Mishaps with nothing to choose and nothing to see: there is one leaf at a time.
struct OneWay : Mishaps {
  static constexpr int kActionCount = 1;
  template <class D>
  static Key observe(const Params&, const Fixed&, const State&, int, D&, const State&) {
    return 0;
  }
  template <class D>
  static double filter(const Params& params, const Fixed& fixed, const State& state, int action, Key,
                       D& draws, State& next) {
    return step(params, fixed, state, action, draws, next).terminal ? 0.0 : 1.0;
  }
  template <class D>
  static double observation_density(const Params&, const Fixed&, const State&, int, Key, D&, const State&) {
    return 1.0;
  }
};

ModelDescriptor one_way_descriptor() {
  ModelDescriptor model = mishaps_descriptor(9.0, 9);
  const ModelDescriptor own = make_descriptor<OneWay>();
  model.action_count = own.action_count;
  model.create = own.create;
  model.action_names = {"on"};
  return model;
}

void expect_sound(const Decision& decision, const ModelDescriptor& model, const std::set<Status>& allowed) {
  EXPECT_GE(decision.action, 0);
  EXPECT_LT(decision.action, model.action_count);
  EXPECT_FALSE(decision.lower > decision.upper);
  EXPECT_EQ(allowed.count(decision.status), 1U) << status_name(decision.status);
}

TEST(Faults, LittleOfAnythingStillGivesALegalAction) {
  PlannerOptions late = by_threads(32), small = by_threads(32), single = by_threads(32, 300);
  late.time_limit = 0.001;
  small.memory_bytes = std::size_t{1} << 20;
  small.trial_limit = 100000;
  single.scenarios = 1;
  for (const ModelDescriptor& model :
       {tiger_descriptor(), rock_sample_descriptor<4, 3>(), one_way_descriptor()}) {
    for (const PlannerOptions& options : {late, small, single}) {
      Solver solver(model, options);
      for (int step = 0; step < 3; ++step) {
        expect_sound(solver.plan(step), model,
                     {Status::kDeadline, Status::kMemoryFull, Status::kTrialLimit, Status::kConverged});
      }
    }
  }
}

// Threads that see no trial left end; of those that others give back none is lost, however small the limit.
TEST(Faults, SmallTrialLimitsAreExact) {
  for (std::uint64_t limit = 1; limit <= 24; ++limit) {
    for (const std::size_t threads : {2, 16}) {
      PlannerOptions options = by_threads(threads, limit);
      options.gap = -1.0;
      Solver solver(tiger_descriptor(), options);
      const Decision decision = solver.plan();
      EXPECT_EQ(decision.status, Status::kTrialLimit);
      EXPECT_EQ(decision.trials, limit);
    }
  }
}

// An evaluator that stands in for a GPU, with the CPU's results.
class Wrapper : public LeafEvaluator {
 public:
  explicit Wrapper(std::unique_ptr<LeafEvaluator> inner) : inner_(std::move(inner)) {}
  std::size_t threads() const override { return inner_->threads(); }
  void attach(std::size_t thread) override { inner_->attach(thread); }
  RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) override {
    return inner_->begin_search(root, setup);
  }
  std::size_t submit(std::size_t thread, Span<const LeafRequest> requests) override {
    return inner_->submit(thread, requests);
  }
  bool poll(std::size_t thread, LeafResult& result) override { return inner_->poll(thread, result); }
  void release() override { inner_->release(); }

 private:
  std::unique_ptr<LeafEvaluator> inner_;
};

// Its device hangs in the first search: it is silent there, found lost by the next, and must not be
// destroyed.
class HangingEvaluator final : public Wrapper {
 public:
  HangingEvaluator(std::unique_ptr<LeafEvaluator> inner, int& destroyed)
      : Wrapper(std::move(inner)), destroyed_(destroyed) {}
  ~HangingEvaluator() override { ++destroyed_; }

  RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) override {
    if (searches_++ > 0) return {Status::kDeviceLost, {}, -1};
    return Wrapper::begin_search(root, setup);
  }
  bool poll(std::size_t, LeafResult&) override { return false; }
  std::string problem() const override { return searches_ > 1 ? "it hangs" : ""; }
  bool is_stuck() override { return searches_ > 1; }

 private:
  int& destroyed_;
  int searches_ = 0;
};

TEST(Faults, ADeviceThatHangsIsLeftBehind) {
  PlannerOptions options = by_threads(4, 50);
  options.patience = 0.02;
  const Solver solver(rock_sample_descriptor<4, 3>(), options);
  PlannerOptions fewer = options;  // the evaluator that follows serves fewer threads
  fewer.threads = 2;
  const auto evaluator = [&](const PlannerOptions& planning) {
    return solver.instance->make_evaluator(evaluator_options(planning, solver.model));
  };
  int destroyed = 0;
  {
    // A planner's last evaluator is not destroyed either.
    Planner planner(std::make_unique<HangingEvaluator>(evaluator(options), destroyed), solver.model, options);
    planner.prepare(*solver.belief);
    EXPECT_EQ(planner.plan(*solver.belief, 0, 0).status, Status::kEvaluatorFailed);
    EXPECT_EQ(planner.plan(*solver.belief, 0, 1).status, Status::kDeviceLost);
  }
  Planner planner(std::make_unique<HangingEvaluator>(evaluator(options), destroyed), solver.model, options);
  planner.prepare(*solver.belief);
  planner.set_fallback([&](const std::string& problem) {
    EXPECT_EQ(problem, "it hangs");
    return evaluator(fewer);
  });
  const std::set<Status> failures{Status::kEvaluatorFailed, Status::kDeviceLost};
  for (int step = 0; step < 2; ++step) {
    const Decision decision = planner.plan(*solver.belief, 0, step);
    EXPECT_GE(decision.action, 0);
    EXPECT_EQ(failures.count(decision.status), 1U);
  }
  EXPECT_EQ(planner.threads(), 4U);
  const Decision decision = checked_plan(planner, *solver.belief, 2);
  EXPECT_EQ(decision.status, Status::kTrialLimit);
  EXPECT_EQ(decision.trials, 50U);
  EXPECT_EQ(planner.threads(), 2U);
  EXPECT_EQ(destroyed, 0);
}

// Fails before there is a tree, or answers with a leaf that nobody asked for.
class FailingEvaluator final : public Wrapper {
 public:
  FailingEvaluator(std::unique_ptr<LeafEvaluator> inner, Status at_root)
      : Wrapper(std::move(inner)), at_root_(at_root) {}

  RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) override {
    if (at_root_ != Status::kOk) return {at_root_, {}, -1};
    return Wrapper::begin_search(root, setup);
  }
  bool poll(std::size_t thread, LeafResult& result) override {
    const bool found = Wrapper::poll(thread, result);
    if (found && result.ticket > 20) ++result.ticket;
    return found;
  }

 private:
  Status at_root_;
};

TEST(Faults, EvaluatorsThatFailAtTheRootOrConfuseLeavesDoNoHarm) {
  const PlannerOptions options = by_threads(4, 500);
  const Solver solver(rock_sample_descriptor<4, 3>(), options);
  for (const Status status :
       {Status::kOk, Status::kModelNan, Status::kMemoryFull, Status::kEvaluatorFailed}) {
    auto inner = solver.instance->make_evaluator(evaluator_options(options, solver.model));
    Planner planner(std::make_unique<FailingEvaluator>(std::move(inner), status), solver.model, options);
    planner.prepare(*solver.belief);
    const Decision decision = planner.plan(*solver.belief, 0, 0);
    const Status expected = status == Status::kOk ? Status::kEvaluatorFailed : status;
    expect_sound(decision, solver.model, {expected});
  }
}

TEST(Faults, LateAnswersCostTimeAndNothingElse) {
  PlannerOptions options = by_threads(16);
  options.time_limit = 0.02;
  const Solver solver(one_way_descriptor(), options);
  auto inner = solver.instance->make_evaluator(evaluator_options(options, solver.model));
  Planner planner(std::make_unique<MockEvaluator>(std::move(inner), Mischief{7}), solver.model, options);
  planner.prepare(*solver.belief);
  for (int step = 0; step < 5; ++step) {
    expect_sound(checked_plan(planner, *solver.belief, step), solver.model,
                 {Status::kConverged, Status::kDeadline});
  }
}

}  // namespace
}  // namespace hypgen::testing
