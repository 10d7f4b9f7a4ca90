// SPDX-License-Identifier: Apache-2.0
#include "hypgen/embed/c_api.hpp"

#include <gtest/gtest.h>
#include <hypgen.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "embedded_rocks.hpp"
#include "fake_support.hpp"

namespace {

using hypgen::EmbeddedModel;
using hypgen::ValueKind;
using hypgen::testing::rocks;

template <int kUpper>
EmbeddedModel mishaps() {
  const double upper = kUpper == 0 ? std::numeric_limits<double>::quiet_NaN() : kUpper;
  EmbeddedModel model{hypgen::testing::mishaps_descriptor(upper, 9), {}, {}};
  model.visible = {{"count", {}, ValueKind::kInt, 0, 9}};
  model.seen = {{"hidden", {}, ValueKind::kBool, 0, 1}};
  return model;
}

EmbeddedModel without_actions() {
  EmbeddedModel model = mishaps<10>();
  model.descriptor.params[1].defaults = {0.0};
  return model;
}

// Rocks on a GPU that ends a search so after some leaves.
template <hypgen::Status kEnd>
EmbeddedModel on_bad_gpu() {
  static const hypgen::testing::FakeSupport gpu(true, {1, 5, kEnd});
  EmbeddedModel model = rocks();
  model.descriptor.device = &gpu;
  return model;
}

void another_runtime() {}

// A failing call leaves a text, which this frees.
class CApiTest : public ::testing::Test {
 protected:
  ~CApiTest() override { hypgen_free(error); }

  void make(EmbeddedModel (*model)(), const char* settings, const char* params = nullptr) {
    hypgen_destroy(planner);
    kept = {&hypgen::this_runtime, model};
    const hypgen_options options = {sizeof(hypgen_options), settings, params};
    made = hypgen_create(&kept, &options, &planner, fresh());
  }

  char** fresh() {
    hypgen_free(error);
    error = nullptr;
    return &error;
  }

  void TearDown() override { EXPECT_EQ(hypgen_destroy(planner), HYPGEN_OK); }

  hypgen_status plan(double seconds = 0.0) { return hypgen_plan(planner, seconds, &decision, fresh()); }

  hypgen_model kept{};
  hypgen_planner* planner = nullptr;
  hypgen_status made = HYPGEN_OK;
  hypgen_decision decision = {sizeof(hypgen_decision), 0, 0, nullptr, 0, 0, 0, 0, 0, 0, 0, 0};
  char* error = nullptr;
};

constexpr const char* kFew = "mode=despot trials=50 scenarios=50 particles=200 memory=64";

TEST_F(CApiTest, PlansByNamesValuesAndKeys) {
  make(rocks, kFew);
  ASSERT_EQ(made, HYPGEN_OK) << error;
  ASSERT_EQ(hypgen_reset(planner, nullptr, 0, 0, fresh()), HYPGEN_OK) << error;
  EXPECT_LT(plan(), HYPGEN_FAILED);
  EXPECT_STREQ(hypgen_status_name(decision.status), "trial_limit");
  const char* name = nullptr;
  ASSERT_EQ(hypgen_action_name(planner, decision.action, &name, fresh()), HYPGEN_OK);
  EXPECT_STREQ(name, decision.action_name);
  int32_t check = 0;
  ASSERT_EQ(hypgen_find_action(planner, "check(1)", &check, fresh()), HYPGEN_OK);
  const char* seen = R"({"reading": "looks_good"})";
  const int32_t value = 1;
  uint64_t key = 9, same = 8;
  ASSERT_EQ(hypgen_encode_named(planner, seen, &key, 1, fresh()), HYPGEN_OK);
  ASSERT_EQ(hypgen_encode(planner, &value, 1, &same, 1, fresh()), HYPGEN_OK);
  EXPECT_EQ(key, same);
  char* names = nullptr;
  ASSERT_EQ(hypgen_decode(planner, &key, 1, &names, fresh()), HYPGEN_OK);
  EXPECT_STREQ(names, R"({"reading":"looks_good"})");
  hypgen_free(names);
  EXPECT_EQ(hypgen_update_named(planner, check, seen, fresh()), HYPGEN_OK);
  EXPECT_EQ(hypgen_update_values(planner, check, &value, 1, fresh()), HYPGEN_OK);
  EXPECT_EQ(hypgen_update(planner, check, &key, 1, fresh()), HYPGEN_OK);
  double probability = 0.0;
  ASSERT_EQ(hypgen_probability(planner, "good[1]", "true", &probability, fresh()), HYPGEN_OK) << error;
  EXPECT_GT(probability, 0.8);
  char* belief = nullptr;
  ASSERT_EQ(hypgen_belief(planner, &belief, fresh()), HYPGEN_OK);
  const auto json = nlohmann::json::parse(belief);
  hypgen_free(belief);
  EXPECT_EQ(json.size(), 3U);
  EXPECT_NEAR(json[1]["values"][0]["probability"].get<double>(), probability, 1e-9);
  char* info = nullptr;
  ASSERT_EQ(hypgen_info(planner, &info, fresh()), HYPGEN_OK);
  EXPECT_EQ(nlohmann::json::parse(info)["step"], 3);
  hypgen_free(info);
}

TEST_F(CApiTest, DescribesTheModel) {
  kept = {&hypgen::this_runtime, rocks};
  char* json = nullptr;
  ASSERT_EQ(hypgen_describe(&kept, &json, fresh()), HYPGEN_OK);
  EXPECT_EQ(nlohmann::json::parse(json)["seen"][0]["values"][2], "looks_bad");
  hypgen_free(json);
  EXPECT_EQ(hypgen_abi_version(), HYPGEN_ABI_VERSION);
}

TEST_F(CApiTest, RefusesWrongArguments) {
  kept = {&hypgen::this_runtime, rocks};
  hypgen_options options = {sizeof(hypgen_options) - 1, kFew, nullptr};
  EXPECT_EQ(hypgen_create(&kept, &options, &planner, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(planner, nullptr);
  EXPECT_EQ(hypgen_create(nullptr, nullptr, &planner, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_create(&kept, nullptr, nullptr, fresh()), HYPGEN_WRONG_ARGUMENT);
  const hypgen_model other = {&another_runtime, rocks};
  EXPECT_EQ(hypgen_create(&other, nullptr, &planner, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_STRNE(error, nullptr);
  make(rocks, "scenarios=0");
  EXPECT_EQ(made, HYPGEN_WRONG_ARGUMENT);
  make(rocks, kFew, "[]");
  EXPECT_EQ(made, HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_destroy(nullptr), HYPGEN_OK);
  EXPECT_EQ(hypgen_plan(nullptr, 0.1, &decision, nullptr), HYPGEN_WRONG_ARGUMENT);

  make(rocks, kFew);
  ASSERT_EQ(made, HYPGEN_OK);
  EXPECT_EQ(plan(), HYPGEN_WRONG_ARGUMENT);  // before reset
  EXPECT_EQ(decision.action, -1);
  const int32_t outside[] = {-5, 0};
  EXPECT_EQ(hypgen_reset(planner, outside, 2, 0, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_STREQ(error, "x: expected an integer from 0 to 3, found -5");
  EXPECT_EQ(hypgen_reset(planner, nullptr, 2, 0, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_reset_named(planner, "{", 0, fresh()), HYPGEN_WRONG_ARGUMENT);
  ASSERT_EQ(hypgen_reset_named(planner, nullptr, 0, fresh()), HYPGEN_OK);
  EXPECT_EQ(error, nullptr);
  EXPECT_EQ(plan(std::nan("")), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_plan(planner, 0.0, nullptr, fresh()), HYPGEN_WRONG_ARGUMENT);
  hypgen_decision short_one = decision;
  short_one.size = 8;
  EXPECT_EQ(hypgen_plan(planner, 0.0, &short_one, fresh()), HYPGEN_WRONG_ARGUMENT);
  const uint64_t key[] = {0, 0}, impossible = 77;
  for (const int32_t action : {-1, 99})
    EXPECT_EQ(hypgen_update(planner, action, key, 1, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_update(planner, 0, &impossible, 1, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_update(planner, 0, key, 2, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_update(planner, 0, nullptr, 1, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_update_named(planner, 0, R"({"smell": "good"})", fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_STREQ(error, "no value is named smell; the names are: reading");
  EXPECT_EQ(hypgen_update_named(planner, 0, "{}", fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_update_named(planner, 0, nullptr, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_update_values(planner, 0, nullptr, 1, fresh()), HYPGEN_WRONG_ARGUMENT);
  int32_t number = 0;
  EXPECT_EQ(hypgen_find_action(planner, "fly", &number, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_find_action(planner, nullptr, &number, fresh()), HYPGEN_WRONG_ARGUMENT);
  const char* name = nullptr;
  EXPECT_EQ(hypgen_action_name(planner, 8, &name, fresh()), HYPGEN_WRONG_ARGUMENT);
  char* text = nullptr;
  EXPECT_EQ(hypgen_decode(planner, &impossible, 1, &text, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_belief(planner, nullptr, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_info(planner, nullptr, fresh()), HYPGEN_WRONG_ARGUMENT);
  double probability = 0.0;
  EXPECT_EQ(hypgen_probability(planner, "moon", "1", &probability, fresh()), HYPGEN_WRONG_ARGUMENT);
}

TEST_F(CApiTest, ReachesEachStatus) {
  const auto begin = [&](EmbeddedModel (*model)(), const char* settings, const char* visible = "{}") {
    make(model, settings);
    ASSERT_EQ(made, HYPGEN_OK) << error;
    ASSERT_EQ(hypgen_reset_named(planner, visible, 0, fresh()), HYPGEN_OK) << error;
  };
  begin(mishaps<10>, kFew);
  EXPECT_EQ(plan(), HYPGEN_CONVERGED);
  begin(mishaps<0>, kFew);
  EXPECT_EQ(plan(), HYPGEN_MODEL_NAN);
  EXPECT_EQ(decision.action, 0);
  begin(mishaps<-1>, kFew);
  EXPECT_EQ(plan(), HYPGEN_BOUNDS_CROSSED);
  EXPECT_GE(decision.action, 0);
  begin(without_actions, kFew);
  EXPECT_EQ(plan(), HYPGEN_NO_LEGAL_ACTION);
  EXPECT_EQ(decision.action, -1);
  const uint64_t nothing = 0;
  begin(mishaps<10>, kFew, R"({"count": 2})");
  EXPECT_EQ(hypgen_update(planner, 0, &nothing, 1, fresh()), HYPGEN_ALL_PARTICLES_TERMINAL);
  begin(rocks, kFew);
  EXPECT_EQ(plan(), HYPGEN_TRIAL_LIMIT);
  EXPECT_EQ(plan(1e-9), HYPGEN_DEADLINE_DEFAULT);
  EXPECT_GE(decision.action, 0);
  EXPECT_EQ(hypgen_update(planner, 5, &nothing, 1, fresh()), HYPGEN_IMPOSSIBLE_OBSERVATION);
  // Beside the first rock a check is sure: half of the hypotheses go, then those that the rest excludes.
  begin(rocks, "mode=despot trials=10 belief=particle particles=200 memory=64", R"({"x": 1, "y": 0})");
  const uint64_t good = 1, bad = 2;
  EXPECT_EQ(hypgen_update(planner, 5, &good, 1, fresh()), HYPGEN_OK);
  EXPECT_EQ(hypgen_update(planner, 5, &bad, 1, fresh()), HYPGEN_BELIEF_DEPLETED);
  EXPECT_EQ(plan(), HYPGEN_TRIAL_LIMIT);
  begin(rocks, "mode=despot time=0.1 memory=64");
  EXPECT_EQ(plan(), HYPGEN_DEADLINE);
  begin(rocks, "mode=despot trials=1000000 memory=1");
  EXPECT_EQ(plan(), HYPGEN_MEMORY_FULL);
  EXPECT_GE(decision.action, 0);
  begin(on_bad_gpu<hypgen::Status::kDeviceLost>, "mode=gpu trials=100 memory=64");
  EXPECT_EQ(plan(), HYPGEN_GPU_LOST);
  EXPECT_GE(decision.action, 0);
  EXPECT_EQ(plan(), HYPGEN_TRIAL_LIMIT);  // on the CPU
  begin(on_bad_gpu<hypgen::Status::kEvaluatorFailed>, "mode=gpu trials=100 memory=64");
  EXPECT_EQ(plan(), HYPGEN_EVALUATOR_FAILED);
  EXPECT_GE(decision.action, 0);
  make(rocks, "mode=gpu require-gpu");
  EXPECT_EQ(made, HYPGEN_NO_GPU);
  make(rocks, "mode=despot memory=1000000 particles=100");
  EXPECT_EQ(made, HYPGEN_NO_MEMORY);
}

TEST_F(CApiTest, RefusesASecondThread) {
  make(rocks, kFew);
  ASSERT_EQ(made, HYPGEN_OK);
  ASSERT_EQ(hypgen_reset(planner, nullptr, 0, 0, fresh()), HYPGEN_OK);
  std::atomic<int> refused{0}, taken{0};
  const auto ask = [&] {
    for (int i = 0; i < 100000 && refused == 0; ++i) {
      double probability = 0.0;
      char* text = nullptr;
      const hypgen_status status = hypgen_probability(planner, "good[0]", "true", &probability, &text);
      EXPECT_TRUE(status == HYPGEN_OK || (status == HYPGEN_BUSY && text != nullptr));
      hypgen_free(text);
      ++(status == HYPGEN_OK ? taken : refused);
    }
  };
  std::thread first(ask), second(ask);
  first.join();
  second.join();
  EXPECT_GT(refused, 0);
  EXPECT_GT(taken, 0);
}

TEST_F(CApiTest, CancelsThePlanOfAnotherThread) {
  for (const char* mode : {"despot", "parallel threads=2", "pomcp", "rollout"}) {
    make(rocks, (std::string("time=60 scenarios=500 memory=64 mode=") + mode).c_str());
    ASSERT_EQ(made, HYPGEN_OK) << error;
    ASSERT_EQ(hypgen_reset(planner, nullptr, 0, 0, fresh()), HYPGEN_OK);
    EXPECT_EQ(hypgen_cancel(planner), HYPGEN_OK);  // of no plan: the next one is whole
    std::atomic<bool> is_planning{true};
    std::thread other([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(30));
      while (is_planning) hypgen_cancel(planner);  // from before the plan, if that is late
    });
    const hypgen_status status = plan();
    is_planning = false;
    other.join();
    EXPECT_TRUE(status == HYPGEN_DEADLINE || status == HYPGEN_DEADLINE_DEFAULT ||
                status == HYPGEN_CONVERGED || status == HYPGEN_MEMORY_FULL)
        << mode << ": " << hypgen_status_name(status);
    EXPECT_GE(decision.action, 0);
    EXPECT_LT(decision.seconds, 30.0) << mode;
  }
  EXPECT_EQ(hypgen_cancel(nullptr), HYPGEN_WRONG_ARGUMENT);
}

TEST_F(CApiTest, PlansUntilATime) {
  make(rocks, "mode=despot scenarios=100 particles=200 memory=64");
  ASSERT_EQ(hypgen_reset(planner, nullptr, 0, 0, fresh()), HYPGEN_OK);
  EXPECT_EQ(hypgen_plan_until(planner, hypgen_now() - 1000, &decision, fresh()), HYPGEN_DEADLINE_DEFAULT);
  EXPECT_GE(decision.action, 0);
  EXPECT_EQ(hypgen_plan_until(planner, INT64_MIN, &decision, fresh()), HYPGEN_DEADLINE_DEFAULT);
  const int64_t end = hypgen_now() + 20'000'000;
  EXPECT_LT(hypgen_plan_until(planner, end, &decision, fresh()), HYPGEN_FAILED);
  EXPECT_LT(decision.seconds, 10.0);
}

TEST_F(CApiTest, DrawsStatesFromTheBelief) {
  make(rocks, kFew);
  ASSERT_EQ(hypgen_reset(planner, nullptr, 0, 0, fresh()), HYPGEN_OK);
  constexpr std::size_t kCount = 2000, kEach = 5;  // x, y and three rocks
  std::vector<std::int32_t> values(kCount * kEach);
  ASSERT_EQ(hypgen_sample_belief(planner, 1, kCount, values.data(), values.size(), fresh()), HYPGEN_OK)
      << error;
  double good = 0.0, expected = 0.0;
  for (std::size_t i = 0; i < kCount; ++i) good += values[i * kEach + 3];
  ASSERT_EQ(hypgen_probability(planner, "good[1]", "true", &expected, fresh()), HYPGEN_OK) << error;
  EXPECT_NEAR(good / kCount, expected, 0.06);
  EXPECT_EQ(values[0], values[kEach]);  // all states have the visible place
  EXPECT_EQ(hypgen_sample_belief(planner, 1, 3, values.data(), 14, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_sample_belief(planner, 1, SIZE_MAX, values.data(), 14, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_sample_belief(planner, 1, 3, nullptr, 15, fresh()), HYPGEN_WRONG_ARGUMENT);
  for (const char* name : {"maybe", "2", ""})
    EXPECT_EQ(hypgen_probability(planner, "good[1]", name, &expected, fresh()), HYPGEN_WRONG_ARGUMENT);
}

TEST_F(CApiTest, WarmsUpBeforeAnEpisode) {
  make(rocks, kFew);
  EXPECT_LT(hypgen_warm_up(planner, 0.01, fresh()), HYPGEN_FAILED) << error;
  EXPECT_EQ(plan(), HYPGEN_WRONG_ARGUMENT);  // no episode has begun
  EXPECT_EQ(hypgen_warm_up(planner, -1.0, fresh()), HYPGEN_WRONG_ARGUMENT);
  ASSERT_EQ(hypgen_reset(planner, nullptr, 0, 5, fresh()), HYPGEN_OK);
  plan();
  const hypgen_decision after = decision;
  make(rocks, kFew);
  ASSERT_EQ(hypgen_reset(planner, nullptr, 0, 5, fresh()), HYPGEN_OK);
  plan();
  EXPECT_EQ(after.action, decision.action);
  EXPECT_EQ(after.lower, decision.lower);
}

TEST_F(CApiTest, RefusesAForkedProcess) {
  make(rocks, "mode=parallel threads=2 trials=20 memory=64");
  ASSERT_EQ(made, HYPGEN_OK);
  ASSERT_EQ(hypgen_reset(planner, nullptr, 0, 0, fresh()), HYPGEN_OK);
  const pid_t child = fork();
  if (child == 0) {
    const bool is_right = plan() == HYPGEN_WRONG_ARGUMENT && hypgen_destroy(planner) == HYPGEN_OK;
    _exit(is_right ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_LT(plan(), HYPGEN_FAILED);
}

// A handle's number is never used again, so the next planner does not get the calls of the last one.
TEST_F(CApiTest, RefusesWhatWasDestroyed) {
  make(rocks, kFew);
  ASSERT_EQ(made, HYPGEN_OK) << error;
  hypgen_planner* const old = planner;
  EXPECT_EQ(hypgen_destroy(old), HYPGEN_OK);
  EXPECT_EQ(hypgen_destroy(old), HYPGEN_WRONG_ARGUMENT);
  make(rocks, kFew);
  ASSERT_EQ(made, HYPGEN_OK) << error;
  EXPECT_NE(old, planner);
  EXPECT_EQ(hypgen_plan(old, 0.1, &decision, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_STREQ(error, "planner: was destroyed, or another library has made it");
  EXPECT_EQ(hypgen_reset_named(old, nullptr, 0, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_update_named(old, 0, "{}", fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_cancel(old), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_destroy(old), HYPGEN_WRONG_ARGUMENT);
  auto* const worlds = reinterpret_cast<hypgen_worlds*>(planner);
  EXPECT_EQ(hypgen_worlds_destroy(worlds), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_reset(planner, nullptr, 0, 0, fresh()), HYPGEN_OK);
}

// Threads call a planner that one of them destroys: each call is served or refused.
TEST(CApi, DestroysWhileOthersCall) {
  const hypgen_model model = {&hypgen::this_runtime, rocks};
  const hypgen_options options = {sizeof(hypgen_options), kFew, nullptr};
  for (int round = 0; round < 5; ++round) {
    hypgen_planner* planner = nullptr;
    ASSERT_EQ(hypgen_create(&model, &options, &planner, nullptr), HYPGEN_OK);
    std::atomic<bool> is_alive{true};
    std::vector<std::thread> callers;
    for (int i = 0; i < 2; ++i) {
      callers.emplace_back([&] {
        while (is_alive) {
          hypgen_cancel(planner);
          const hypgen_status status = hypgen_reset(planner, nullptr, 0, 0, nullptr);
          EXPECT_TRUE(status == HYPGEN_OK || status == HYPGEN_BUSY || status == HYPGEN_WRONG_ARGUMENT);
        }
      });
    }
    while (hypgen_destroy(planner) == HYPGEN_BUSY) std::this_thread::yield();
    is_alive = false;
    for (std::thread& caller : callers) caller.join();
  }
}

// A fork that comes while another thread looks up a handle does not wait for that thread, which it has not.
TEST_F(CApiTest, ForksWhileAnotherThreadCalls) {
  make(rocks, kFew);
  ASSERT_EQ(made, HYPGEN_OK) << error;
  std::atomic<bool> is_over{false};
  std::thread other([&] {
    while (!is_over) hypgen_cancel(planner);
  });
  for (int round = 0; round < 20; ++round) {
    const pid_t child = fork();
    if (child == 0) {
      alarm(20);
      _exit(hypgen_plan(planner, 0.1, &decision, nullptr) == HYPGEN_WRONG_ARGUMENT ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  }
  is_over = true;
  other.join();
}

// Twenty planners at a time, of two models, each in a thread of its own.
TEST(CApi, HasSeveralPlanners) {
  std::vector<std::thread> threads;
  for (int i = 0; i < 20; ++i) {
    threads.emplace_back([i] {
      const hypgen_model model = {&hypgen::this_runtime, i % 2 ? rocks : mishaps<10>};
      const hypgen_options options = {sizeof(hypgen_options), kFew, nullptr};
      hypgen_planner* planner = nullptr;
      hypgen_decision decision{};
      decision.size = sizeof decision;
      ASSERT_EQ(hypgen_create(&model, &options, &planner, nullptr), HYPGEN_OK);
      EXPECT_EQ(hypgen_reset(planner, nullptr, 0, 0, nullptr), HYPGEN_OK);
      EXPECT_LT(hypgen_plan(planner, 0.0, &decision, nullptr), HYPGEN_FAILED);
      EXPECT_EQ(hypgen_destroy(planner), HYPGEN_OK);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
