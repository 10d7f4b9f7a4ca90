// SPDX-License-Identifier: Apache-2.0
// Every member of hypgen.hpp, with RockSample's library. Names the line that went wrong.
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <hypgen.hpp>
#include <string>
#include <utility>
#include <vector>

#include "rock_sample.h"

namespace {

using hypgen::api::Error;
using hypgen::api::Planner;
using hypgen::api::Worlds;

constexpr const char* kSettings = "mode=despot trials=20 scenarios=50 memory=64";

#define MUST(condition)                \
  do {                                 \
    if (!(condition)) return __LINE__; \
  } while (0)

// Whether `refused` throws what hypgen.h says of a status, with this in its text.
template <class Refused>
bool throws(hypgen_status status, const char* text, const Refused& refused) {
  try {
    refused();
  } catch (const Error& error) {
    return error.status() == status && std::string(error.what()).find(text) != std::string::npos;
  }
  return false;
}

int plans() {
  Planner made(hypgen_model_rock_sample(), kSettings, R"({"sure": 0.9})");
  MUST(throws(HYPGEN_WRONG_ARGUMENT, "no episode has begun", [&] { made.plan(); }));
  Planner planner = std::move(made);
  MUST(throws(HYPGEN_WRONG_ARGUMENT, "planner: is NULL", [&] { made.plan(); }));
  MUST(planner.warm_up() < HYPGEN_FAILED);
  MUST(planner.reset_named(R"({"rover.x": 2})", 1) == HYPGEN_OK);
  MUST(planner.reset_values({2, 3}, 1) == HYPGEN_OK);
  MUST(throws(HYPGEN_WRONG_ARGUMENT, "expected 2 value(s), found 1", [&] { planner.reset_values({2}); }));
  MUST(planner.reset() == HYPGEN_OK);

  const hypgen_decision decision = planner.plan(60.0);
  MUST(decision.status == HYPGEN_TRIAL_LIMIT || decision.status == HYPGEN_CONVERGED);
  MUST(planner.action_name(decision.action) == std::string(decision.action_name));
  MUST(planner.find_action(decision.action_name) == decision.action);
  MUST(throws(HYPGEN_WRONG_ARGUMENT, "sing", [&] { planner.find_action("sing"); }));
  MUST(planner.tree(1, 2, 100).front() == '{');
  MUST(planner.plan_until(std::chrono::steady_clock::now()).status == HYPGEN_DEADLINE_DEFAULT);
  planner.cancel();

  std::array<std::uint64_t, 1> key{};
  planner.encode({ROCK_SAMPLE_READING_LOOKS_GOOD}, key);
  std::vector<std::uint64_t> same(1);
  planner.encode_named(R"({"reading": "looks_good"})", same);
  MUST(same[0] == key[0] && planner.decode(key).find("looks_good") != std::string::npos);
  const std::int32_t check = planner.find_action("check(0)");
  MUST(planner.update(check, key) == HYPGEN_OK);
  MUST(planner.update_values(check, std::array<std::int32_t, 1>{ROCK_SAMPLE_READING_LOOKS_GOOD}) ==
       HYPGEN_OK);
  MUST(planner.update_named(check, R"({"reading": "looks_good"})") == HYPGEN_OK);
  MUST(planner.probability("rock.good[0]", "true") > 0.5);
  MUST(planner.belief().front() == '[' && planner.info().find("despot") != std::string::npos);
  std::vector<std::int32_t> states(std::size_t{10} * (8 + ROCK_SAMPLE_VISIBLE));
  planner.sample_belief(1, 10, states);
  MUST(hypgen_info(planner.get(), nullptr, nullptr) == HYPGEN_WRONG_ARGUMENT);
  return 0;
}

int simulates() {
  Worlds worlds(hypgen_model_rock_sample(), 20, 1);
  MUST(worlds.get() != nullptr && worlds.count() == 20);
  worlds.seed(2);
  worlds.start(R"({"rock.good[0]": true})");
  worlds.start();
  worlds.reset();
  std::vector<std::int32_t> visible(20 * ROCK_SAMPLE_VISIBLE);
  worlds.visible(visible.data());
  std::vector<std::uint8_t> legal(20 * 13);
  worlds.legal(legal.data());
  std::array<double, 20> rewards{};
  hypgen_worlds_results results = {};
  results.rewards = rewards.data();
  const std::array<std::int32_t, 20> actions{};
  MUST(legal[0] == 1 && worlds.step(actions.data(), results) == HYPGEN_OK);
  const std::array<std::int32_t, 20> wrong{99};
  MUST(throws(HYPGEN_WRONG_ARGUMENT, "action", [&] { worlds.step(wrong.data(), results); }));
  return 0;
}

int refuses() {
  const hypgen_model* model = hypgen_model_rock_sample();
  MUST(hypgen::api::describe(model).find("\"RockSample\"") != std::string::npos);
  MUST(throws(HYPGEN_WRONG_ARGUMENT, "model: is NULL", [] { hypgen::api::describe(nullptr); }));
  MUST(throws(HYPGEN_WRONG_ARGUMENT, "no setting is named scenario", [&] { Planner(model, "scenario=3"); }));
  MUST(throws(HYPGEN_WRONG_ARGUMENT, "sure", [&] { Planner(model, kSettings, R"({"sure": 7})"); }));
  MUST(throws(HYPGEN_WRONG_ARGUMENT, "count", [&] { Worlds(model, 0); }));
  MUST(throws(HYPGEN_WRONG_ARGUMENT, "device", [&] { Worlds(model, 1, 0, "", "moon"); }));
  MUST(throws(HYPGEN_WRONG_ARGUMENT, "library: has version 99 of hypgen.h",
              [] { hypgen::api::detail::check_interface(99); }));
  return 0;
}

}  // namespace

int main() {
  try {
    for (const auto run : {plans, simulates, refuses})
      if (const int line = run()) {
        std::fprintf(stderr, "line %d failed\n", line);
        return 1;
      }
    std::puts("all calls are as hypgen.h says");
    return 0;
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "%s\n", problem.what());
    return 1;
  }
}
