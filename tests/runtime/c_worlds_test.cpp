// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <hypgen.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstddef>
#include <string>
#include <thread>
#include <vector>

#include "embedded_rocks.hpp"
#include "fake_support.hpp"
#include "hypgen/embed/c_api.hpp"
#include "hypgen/episode/world.hpp"
#include "hypgen/solver/model_instance.hpp"

namespace {

using hypgen::EmbeddedModel;
using hypgen::testing::rocks;

constexpr int32_t kNorth = 0, kEast = 2, kSample = 4, kCheck = 5;
constexpr std::size_t kActions = 8, kVisible = 2;

// Action 1 earns no number.
struct Brittle : hypgen::testing::Mishaps {
  template <class D>
  static hypgen::StepResult step(const Params& params, const Fixed& fixed, const State& state, int action,
                                 D& draws, State& next) {
    hypgen::StepResult result = Mishaps::step(params, fixed, state, action, draws, next);
    result.error = action == 1;
    return result;
  }
};

EmbeddedModel brittle() {
  EmbeddedModel model{hypgen::testing::mishaps_descriptor(9, 9), {}, {}};
  model.descriptor.create = hypgen::make_descriptor<Brittle>().create;
  model.visible = {{"count", {}, hypgen::ValueKind::kInt, 0, 9}};
  model.seen = {{"hidden", {}, hypgen::ValueKind::kBool, 0, 1}};
  return model;
}

// Rocks on a machine with a GPU, and on one without.
EmbeddedModel rocks_with(const hypgen::DeviceSupport& support) {
  EmbeddedModel model = rocks();
  model.descriptor.device = &support;
  return model;
}

EmbeddedModel gpu_rocks() {
  static const hypgen::testing::FakeSupport support(true);
  return rocks_with(support);
}

EmbeddedModel lost_rocks() {
  static const hypgen::testing::FakeSupport support(false);
  return rocks_with(support);
}

// Worlds with an array for each result. A failing call leaves a text, which this frees.
class CWorldsTest : public ::testing::Test {
 protected:
  ~CWorldsTest() override { hypgen_free(error); }
  void TearDown() override { EXPECT_EQ(hypgen_worlds_destroy(worlds), HYPGEN_OK); }

  // Gives the status of making them.
  hypgen_status make(EmbeddedModel (*model)(), std::size_t number, uint64_t seed = 0,
                     const char* params = nullptr, const char* device = nullptr) {
    hypgen_worlds_destroy(worlds);
    count = number;
    kept = {&hypgen::this_runtime, model};
    const hypgen_worlds_options options = {sizeof options, number, seed, params, device};
    const hypgen_status status = hypgen_worlds_create(&kept, &options, &worlds, fresh());
    if (status != HYPGEN_OK) return status;
    rewards.resize(number);
    seen.resize(number);
    keys.resize(number);
    visible.resize(number * kVisible);
    legal.resize(number * kActions);
    terminal.resize(number);
    success.resize(number);
    results = {sizeof results, rewards.data(), seen.data(),     keys.data(),
               visible.data(), legal.data(),   terminal.data(), success.data()};
    return HYPGEN_OK;
  }

  hypgen_status reset() { return hypgen_worlds_reset(worlds, nullptr, nullptr, count, fresh()); }
  hypgen_status step(const std::vector<int32_t>& actions) {
    return hypgen_worlds_step(worlds, actions.data(), actions.size(), &results, fresh());
  }

  char** fresh() {
    hypgen_free(error);
    error = nullptr;
    return &error;
  }

  hypgen_model kept{};
  hypgen_worlds* worlds = nullptr;
  std::size_t count = 0;
  std::vector<double> rewards;
  std::vector<int32_t> seen, visible;
  std::vector<uint64_t> keys;
  std::vector<uint8_t> legal, terminal, success;
  hypgen_worlds_results results{};
  char* error = nullptr;
};

TEST_F(CWorldsTest, PlaysTheEpisodesOfTheSolversWorld) {
  std::string problem;
  const auto instance = rocks().descriptor.create({}, problem);
  const auto alone = instance->make_world(7);
  for (std::size_t episode = 0; episode < 6;
       ++episode) {  // the second episodes of three worlds are 3, 4 and 5
    ASSERT_EQ(make(rocks, 3, 8), HYPGEN_OK) << error;
    ASSERT_EQ(hypgen_worlds_seed(worlds, 7, fresh()), HYPGEN_OK);
    ASSERT_EQ(reset(), HYPGEN_OK) << error;
    if (episode >= 3) {
      ASSERT_EQ(step(std::vector<int32_t>(3, HYPGEN_NEXT_EPISODE)), HYPGEN_OK);
    }
    const std::size_t i = episode % 3;
    alone->reset(episode);
    for (const int32_t action : {kCheck, kCheck + 1, kEast, kCheck + 2, kEast, kEast, kCheck, kEast}) {
      std::vector<int32_t> actions(3, kCheck);  // what the others do does not matter
      actions[i] = action;
      const hypgen::WorldStep expected = alone->step(action);
      ASSERT_EQ(step(actions), HYPGEN_OK) << error;
      std::vector<int32_t> places(kVisible);
      alone->export_visible(places.data());
      EXPECT_EQ(keys[i], expected.key[0]);
      EXPECT_EQ(seen[i], static_cast<int32_t>(expected.key[0]));
      EXPECT_EQ(rewards[i], expected.reward);
      EXPECT_EQ(terminal[i] != 0, expected.result.terminal);
      if (expected.result.terminal) break;
      EXPECT_EQ(visible[2 * i], places[0]);
      EXPECT_EQ(legal[i * kActions + kSample] != 0, alone->is_legal(kSample));
    }
    EXPECT_TRUE(terminal[i]);
  }
}

TEST_F(CWorldsTest, EndsEpisodesAndStartsTheNext) {
  ASSERT_EQ(make(rocks, 2), HYPGEN_OK);
  ASSERT_EQ(step({HYPGEN_NEXT_EPISODE, HYPGEN_NEXT_EPISODE}), HYPGEN_OK) << error;
  for (int i = 0; i < 3; ++i) ASSERT_EQ(step({kEast, kNorth}), HYPGEN_OK) << error;
  ASSERT_EQ(step({kEast, kCheck}), HYPGEN_OK);
  EXPECT_EQ(terminal, (std::vector<uint8_t>{1, 0}));
  EXPECT_EQ(success[0], 1);
  EXPECT_EQ(rewards[0], 10.0);
  EXPECT_EQ(keys[0], 0U);
  EXPECT_EQ(std::vector<uint8_t>(legal.begin(), legal.begin() + kActions), std::vector<uint8_t>(kActions));
  EXPECT_EQ(step({kEast, kNorth}), HYPGEN_WRONG_ARGUMENT);
  EXPECT_STREQ(error, "world 0: no action is legal: its episode has ended, or none has begun");
  ASSERT_EQ(step({HYPGEN_NEXT_EPISODE, kEast}), HYPGEN_OK);
  EXPECT_EQ(visible, (std::vector<int32_t>{0, 2, 1, 3}));
  EXPECT_EQ(rewards[0], 0.0);
  EXPECT_EQ(terminal[0], 0);
  const uint8_t second[] = {0, 1};
  const uint64_t episodes[] = {uint64_t{1} << 40, 9};  // the first is not read
  ASSERT_EQ(hypgen_worlds_reset(worlds, second, episodes, 2, fresh()), HYPGEN_OK) << error;
  ASSERT_EQ(hypgen_worlds_visible(worlds, visible.data(), 2, fresh()), HYPGEN_OK);
  EXPECT_EQ(visible, (std::vector<int32_t>{0, 2, 0, 2}));
  ASSERT_EQ(hypgen_worlds_legal(worlds, legal.data(), 2, fresh()), HYPGEN_OK);
  EXPECT_EQ(legal[kEast], 1);
  EXPECT_EQ(hypgen_worlds_reset(worlds, nullptr, episodes, 2, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_STREQ(error, "world 0: expected an episode below 2^32, found 1099511627776");
}

TEST_F(CWorldsTest, DoesNothingWhereOneIsRefused) {
  ASSERT_EQ(make(rocks, 2), HYPGEN_OK);
  EXPECT_EQ(step({kEast, kEast}), HYPGEN_WRONG_ARGUMENT);  // before reset
  ASSERT_EQ(reset(), HYPGEN_OK);
  EXPECT_EQ(step({kEast, kSample}), HYPGEN_WRONG_ARGUMENT);
  EXPECT_STREQ(error, "world 1: action sample is not legal now");
  for (const int32_t wrong : {-2, 8}) EXPECT_EQ(step({wrong, kEast}), HYPGEN_WRONG_ARGUMENT);
  EXPECT_STREQ(error, "world 0: expected an action from 0 to 7, or HYPGEN_NEXT_EPISODE, found 8");
  ASSERT_EQ(hypgen_worlds_visible(worlds, visible.data(), 2, fresh()), HYPGEN_OK);
  EXPECT_EQ(visible, (std::vector<int32_t>{0, 2, 0, 2}));
}

TEST_F(CWorldsTest, RefusesWrongArguments) {
  EXPECT_EQ(make(rocks, 0), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(worlds, nullptr);
  EXPECT_EQ(make(rocks, std::size_t{1} << 25), HYPGEN_WRONG_ARGUMENT);
  EXPECT_STREQ(error, "count: expected 1 to 2^24 worlds, found 33554432");
  EXPECT_EQ(make(rocks, 1, 0, R"({"no": 1})"), HYPGEN_WRONG_ARGUMENT);
  const hypgen_worlds_options options = {sizeof options - 1, 1, 0, nullptr, nullptr};
  EXPECT_EQ(hypgen_worlds_create(&kept, &options, &worlds, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_worlds_create(&kept, nullptr, &worlds, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_worlds_create(&kept, &options, nullptr, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_worlds_create(nullptr, &options, &worlds, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_worlds_seed(nullptr, 0, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_worlds_destroy(nullptr), HYPGEN_OK);

  ASSERT_EQ(make(rocks, 2), HYPGEN_OK);
  EXPECT_EQ(hypgen_worlds_reset(worlds, nullptr, nullptr, 3, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_STREQ(error, "count: expected 2, found 3");
  ASSERT_EQ(reset(), HYPGEN_OK);
  EXPECT_EQ(step({kEast}), HYPGEN_WRONG_ARGUMENT);
  const int32_t actions[] = {kEast, kEast};
  EXPECT_EQ(hypgen_worlds_step(worlds, nullptr, 2, &results, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_worlds_step(worlds, actions, 2, nullptr, fresh()), HYPGEN_WRONG_ARGUMENT);
  results.size = 8;
  EXPECT_EQ(step({kEast, kEast}), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_worlds_visible(worlds, nullptr, 2, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_worlds_legal(worlds, nullptr, 2, fresh()), HYPGEN_WRONG_ARGUMENT);
  results = {sizeof results, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr};
  EXPECT_EQ(step({kEast, kEast}), HYPGEN_OK);
}

TEST_F(CWorldsTest, TellsOfARewardThatIsNoNumber) {
  ASSERT_EQ(make(brittle, 2), HYPGEN_OK) << error;
  ASSERT_EQ(reset(), HYPGEN_OK);
  EXPECT_EQ(step({0, 1}), HYPGEN_MODEL_NAN);
  EXPECT_EQ(error, nullptr);
  EXPECT_EQ(rewards[0], 0.0);
  EXPECT_TRUE(std::isnan(rewards[1]));
  EXPECT_EQ(visible[1], 1);  // it has moved
}

TEST_F(CWorldsTest, RefusesASecondThread) {
  ASSERT_EQ(make(rocks, 1000), HYPGEN_OK);
  ASSERT_EQ(reset(), HYPGEN_OK);
  std::atomic<int> refused{0}, taken{0};
  const auto ask = [&] {
    std::vector<uint8_t> own(1000 * kActions);
    for (int i = 0; i < 100000 && refused == 0; ++i) {
      const hypgen_status status = hypgen_worlds_legal(worlds, own.data(), 1000, nullptr);
      EXPECT_TRUE(status == HYPGEN_OK || status == HYPGEN_BUSY);
      ++(status == HYPGEN_OK ? taken : refused);
    }
  };
  std::thread first(ask), second(ask);
  first.join();
  second.join();
  EXPECT_GT(refused, 0);
  EXPECT_GT(taken, 0);
}

TEST_F(CWorldsTest, StartWhereTheyAreToldTo) {
  ASSERT_EQ(make(rocks, 2), HYPGEN_OK) << error;
  ASSERT_EQ(hypgen_worlds_start(worlds, R"({"x": 3, "good[0]": true})", fresh()), HYPGEN_OK) << error;
  ASSERT_EQ(reset(), HYPGEN_OK);
  ASSERT_EQ(hypgen_worlds_visible(worlds, visible.data(), count, fresh()), HYPGEN_OK);
  EXPECT_EQ(visible, (std::vector<int32_t>{3, 2, 3, 2}));
  EXPECT_EQ(hypgen_worlds_start(worlds, R"({"x": 4})", fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_STREQ(error, "x: expected an integer from 0 to 3, found 4");
  ASSERT_EQ(step({HYPGEN_NEXT_EPISODE, HYPGEN_NEXT_EPISODE}), HYPGEN_OK);
  EXPECT_EQ(visible, (std::vector<int32_t>{3, 2, 3, 2}));  // what was refused has changed nothing
  ASSERT_EQ(hypgen_worlds_start(worlds, nullptr, fresh()), HYPGEN_OK);
  ASSERT_EQ(step({HYPGEN_NEXT_EPISODE, HYPGEN_NEXT_EPISODE}), HYPGEN_OK);
  EXPECT_EQ(visible, (std::vector<int32_t>{0, 2, 0, 2}));
}

TEST_F(CWorldsTest, AreOnAGpuWhereOneIsAskedFor) {
  for (const char* device : {"cuda", "cuda:3"}) {
    ASSERT_EQ(make(gpu_rocks, 2, 0, nullptr, device), HYPGEN_OK) << error;
    ASSERT_EQ(reset(), HYPGEN_OK);
    ASSERT_EQ(step({kEast, kCheck}), HYPGEN_OK);
    EXPECT_EQ(visible, (std::vector<int32_t>{1, 2, 0, 2}));
    EXPECT_EQ(step({kEast, kSample}), HYPGEN_WRONG_ARGUMENT);
    EXPECT_STREQ(error, "world 1: action sample is not legal now");
  }
  const pid_t child = fork();
  if (child == 0) {
    const bool is_refused = reset() == HYPGEN_WRONG_ARGUMENT && hypgen_worlds_destroy(worlds) == HYPGEN_OK;
    _exit(is_refused ? 0 : 1);
  }
  int result = -1;
  ASSERT_EQ(waitpid(child, &result, 0), child);
  EXPECT_EQ(result, 0);
  EXPECT_EQ(step({hypgen::testing::FakeWorlds::kBreaks, kEast}), HYPGEN_NO_GPU);
  EXPECT_STREQ(error, "GPU: lost");
  EXPECT_EQ(reset(), HYPGEN_NO_GPU);
  EXPECT_EQ(hypgen_worlds_start(worlds, nullptr, fresh()), HYPGEN_NO_GPU);
  EXPECT_EQ(hypgen_worlds_seed(worlds, 1, fresh()), HYPGEN_NO_GPU);
  EXPECT_EQ(hypgen_worlds_legal(worlds, legal.data(), 2, fresh()), HYPGEN_NO_GPU);
  EXPECT_EQ(hypgen_worlds_visible(worlds, visible.data(), 2, fresh()), HYPGEN_NO_GPU);
}

TEST_F(CWorldsTest, SayWhyTheyAreNotOnAGpu) {
  EXPECT_EQ(make(rocks, 2, 0, nullptr, "cpu"), HYPGEN_OK);
  const struct {
    EmbeddedModel (*model)();
    std::size_t count;
    const char* device;
    hypgen_status status;
    const char* text;
  } cases[] = {
      {rocks, 2, "cuda", HYPGEN_NO_GPU, "this solver was built without CUDA"},
      {lost_rocks, 2, "cuda", HYPGEN_NO_GPU, "no GPU"},
      {gpu_rocks, 2, "cuda:0", HYPGEN_NO_GPU, "no GPU with number 0 that this solver has code for"},
      {gpu_rocks, 101, "cuda", HYPGEN_NO_GPU, "101 worlds need more memory than there is"},
      {gpu_rocks, 2, "auto", HYPGEN_WRONG_ARGUMENT, "device: expected cpu, cuda or cuda:N, found auto"},
      {gpu_rocks, 2, "cuda:x", HYPGEN_WRONG_ARGUMENT, "device: expected cpu, cuda or cuda:N, found cuda:x"},
  };
  for (const auto& wrong : cases) {
    EXPECT_EQ(make(wrong.model, wrong.count, 0, nullptr, wrong.device), wrong.status);
    EXPECT_STREQ(error, wrong.text);
    EXPECT_EQ(worlds, nullptr);
  }
}

// A caller that was compiled before the options had a device.
TEST_F(CWorldsTest, TakeTheOptionsOfOlderCallers) {
  kept = {&hypgen::this_runtime, gpu_rocks};
  hypgen_worlds_options options = {offsetof(hypgen_worlds_options, device), 2, 0, nullptr, "not read"};
  EXPECT_EQ(hypgen_worlds_create(&kept, &options, &worlds, fresh()), HYPGEN_OK) << error;
}

TEST_F(CWorldsTest, AreRefusedOnceTheyAreDestroyed) {
  ASSERT_EQ(make(rocks, 2), HYPGEN_OK) << error;
  hypgen_worlds* const old = worlds;
  EXPECT_EQ(hypgen_worlds_destroy(old), HYPGEN_OK);
  EXPECT_EQ(hypgen_worlds_destroy(old), HYPGEN_WRONG_ARGUMENT);
  EXPECT_EQ(hypgen_worlds_seed(old, 1, fresh()), HYPGEN_WRONG_ARGUMENT);
  EXPECT_STREQ(error, "worlds: were destroyed, or another library has made them");
  EXPECT_EQ(step({kNorth, kNorth}), HYPGEN_WRONG_ARGUMENT);
  worlds = nullptr;
}

}  // namespace
