// SPDX-License-Identifier: Apache-2.0
#include "hypgen/solver/device_choice.hpp"

#include <gtest/gtest.h>

#include "fake_support.hpp"
#include "hypgen/solver/solver_main.hpp"
#include "mock_evaluator.hpp"
#include "test_solvers.hpp"

namespace hypgen::testing {
namespace {

class DeviceChoice : public ::testing::Test {
 protected:
  // What is chosen by these words on a machine with this support.
  ChosenEvaluator choose(std::vector<const char*> words, const DeviceSupport* support) {
    words.insert(words.begin(), "solver");
    SolverOptions options;
    std::string error;
    const Machine machine = this_machine(support);
    EXPECT_TRUE(parse_options(static_cast<int>(words.size()), words.data(), machine, options, error))
        << error;
    solver_.model.device = support;
    return choose_evaluator(solver_.model, *solver_.instance, options);
  }

  int solve(std::vector<std::string> words, const DeviceSupport* support) {
    words.insert(words.begin(), {"solver", "--trials", "20", "--runs", "1", "--particles", "100", "--quiet"});
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    solver_.model.device = support;
    return solver_main({solver_.model}, static_cast<int>(arguments.size()), arguments.data());
  }

  Solver solver_{rock_sample_descriptor<4, 3>(), trials(1)};
  FakeSupport works_{true}, fails_{false};
};

TEST_F(DeviceChoice, FollowsModeAndDevice) {
  EXPECT_EQ(choose({}, &works_).device, "cuda:3");
  EXPECT_EQ(choose({}, &fails_).device, "cpu");
  EXPECT_EQ(choose({}, nullptr).problem, "");
  EXPECT_EQ(choose({"--mode", "despot"}, &works_).device, "cpu");
  EXPECT_EQ(choose({"--mode", "gpu"}, &works_).device, "cuda:3");
  EXPECT_EQ(choose({"--device", "cuda"}, &works_).device, "cuda:3");
  EXPECT_EQ(choose({"--device", "cuda:3"}, &works_).device, "cuda:3");
  EXPECT_EQ(choose({"--require-gpu"}, &works_).device, "cuda:3");
  const ChosenEvaluator cpu = choose({"--mode", "gpu", "--device", "cpu"}, &works_);
  EXPECT_EQ(cpu.device, "cpu");
  EXPECT_EQ(cpu.problem, "");
}

TEST_F(DeviceChoice, SaysWhyItIsTheCpu) {
  EXPECT_EQ(choose({"--mode", "gpu"}, nullptr).problem, "this solver was built without CUDA");
  EXPECT_EQ(choose({"--mode", "gpu"}, &fails_).problem, "no GPU");
  EXPECT_EQ(choose({"--device", "cuda:0"}, &works_).problem,
            "no GPU with number 0 that this solver has code for");
  EXPECT_EQ(choose({"--mode", "rollout", "--device", "cuda"}, &works_).problem,
            "--mode rollout does not use a GPU");
  EXPECT_EQ(choose({"--mode", "gpu"}, &fails_).device, "cpu");
  EXPECT_NE(choose({"--mode", "gpu"}, &fails_).evaluator, nullptr);
}

TEST_F(DeviceChoice, RequiringAGpuMayFail) {
  EXPECT_EQ(solve({"--mode", "gpu", "--require-gpu"}, &fails_), 1);
  EXPECT_EQ(solve({"--mode", "gpu"}, &fails_), 0);
  EXPECT_EQ(solve({"--mode", "gpu", "--require-gpu"}, &works_), 0);
}

TEST_F(DeviceChoice, PlansGoOnWithoutTheDevice) {
  const FakeSupport breaks(true, {1, 30, Status::kDeviceLost});
  EXPECT_EQ(solve({"--mode", "gpu"}, &breaks), 0);
  EXPECT_EQ(solve({"--mode", "gpu", "--require-gpu"}, &breaks), 1);

  PlannerOptions options = trials(50);
  std::string error;
  const auto evaluator = [&] {
    return solver_.instance->make_evaluator(evaluator_options(options, solver_.model));
  };
  Planner planner(std::make_unique<MockEvaluator>(evaluator(), Mischief{1, 5, Status::kDeviceLost}),
                  solver_.model, options);
  planner.prepare(*solver_.belief);
  EXPECT_EQ(planner.plan(*solver_.belief, 0, 0).status, Status::kDeviceLost);
  EXPECT_EQ(planner.plan(*solver_.belief, 0, 0).status, Status::kDeviceLost);  // there is nothing else
  EXPECT_GE(planner.plan(*solver_.belief, 0, 0).action, 0);
  planner.set_fallback([&](const std::string& problem) {
    EXPECT_EQ(problem, "");  // a mock has none
    return evaluator();
  });
  EXPECT_EQ(planner.plan(*solver_.belief, 0, 0).status, Status::kTrialLimit);
}

}  // namespace
}  // namespace hypgen::testing
