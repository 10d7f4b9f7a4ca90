// SPDX-License-Identifier: Apache-2.0
#include "hypgen/solver/options.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "test_solvers.hpp"

namespace hypgen {
namespace {

bool parse(std::vector<const char*> words, SolverOptions& options, std::string& error,
           const Machine& machine = {}) {
  words.insert(words.begin(), "solver");
  return parse_options(static_cast<int>(words.size()), words.data(), machine, options, error);
}

std::string error_of(const std::vector<const char*>& words) {
  SolverOptions options;
  std::string error;
  EXPECT_FALSE(parse(words, options, error));
  return error;
}

TEST(Options, ReadsValues) {
  SolverOptions options;
  std::string error;
  ASSERT_TRUE(parse({"--mode", "rollout", "--runs=3", "--first-run", "7", "--time", "0.5", "--seed", "9",
                     "--memory", "2", "--quiet", "--belief", "particle", "--on-depletion", "stop"},
                    options, error))
      << error;
  EXPECT_EQ(options.planner.mode, Mode::kRollout);
  EXPECT_EQ(options.runs, 3U);
  EXPECT_EQ(options.first_run, 7U);
  EXPECT_EQ(options.belief, BeliefKind::kParticle);
  EXPECT_TRUE(options.stop_on_depletion);
  EXPECT_EQ(options.planner.time_limit, 0.5);
  EXPECT_EQ(options.planner.seed, 9U);
  EXPECT_EQ(options.planner.memory_bytes, std::size_t{2} << 20);
  EXPECT_TRUE(options.quiet);
}

TEST(Options, LanesAreUsedUnlessTurnedOff) {
  SolverOptions usual, off;
  std::string error;
  ASSERT_TRUE(parse({"--lanes", "auto"}, usual, error));
  EXPECT_TRUE(usual.planner.lanes);
  ASSERT_TRUE(parse({"--lanes=0"}, off, error));
  EXPECT_FALSE(off.planner.lanes);
  EXPECT_NE(error_of({"--lanes", "8"}).find("auto or 0"), std::string::npos);
}

TEST(Options, TheModeMakesTheMostOfTheMachine) {
  const Machine one{1, [] { return false; }}, several{4, [] { return false; }},
      with_gpu{4, [] { return true; }};
  const auto mode = [](const Machine& machine, const std::vector<const char*>& words = {}) {
    SolverOptions options;
    std::string error;
    EXPECT_TRUE(parse(words, options, error, machine)) << error;
    EXPECT_LE(options.planner.threads, machine.cores);
    return options.planner.mode;
  };
  EXPECT_EQ(mode(one), Mode::kDespot);
  EXPECT_EQ(mode(several), Mode::kParallel);
  EXPECT_EQ(mode(with_gpu), Mode::kHyp);
  EXPECT_EQ(mode(several, {"--trials", "9"}), Mode::kParallel);
  EXPECT_EQ(mode(with_gpu, {"--device", "cpu"}), Mode::kParallel);
  EXPECT_EQ(mode(several, {"--require-gpu"}), Mode::kHyp);
  EXPECT_EQ(mode(several, {"--threads", "1"}), Mode::kDespot);
  EXPECT_EQ(mode(with_gpu, {"--threads", "1"}), Mode::kGpu);
  EXPECT_EQ(mode(with_gpu, {"--signature"}), Mode::kDespot);
  EXPECT_EQ(mode(with_gpu, {"--signature", "--mode", "hyp"}), Mode::kHyp);
  SolverOptions threaded;
  std::string error;
  EXPECT_FALSE(parse({"--signature", "--threads", "2"}, threaded, error, several));
  EXPECT_NE(error.find("name a --mode"), std::string::npos) << error;
  const Machine unasked{4, []() -> bool { throw "a GPU is looked for"; }};
  for (const char* words : {"--mode=despot", "--help", "--version"}) mode(unasked, {words});
}

TEST(Options, RequiringAGpuContradictsWhatUsesNone) {
  EXPECT_EQ(error_of({"--require-gpu", "--device", "cpu"}), "--require-gpu: contradicts --device cpu");
  EXPECT_EQ(error_of({"--mode", "rollout", "--require-gpu"}),
            "--require-gpu: mode rollout does not use a GPU");
}

TEST(Options, MessagesShowBadValuesHarmlessly) {
  EXPECT_EQ(error_of({"--runs", "\x1b[2J\xff"}),
            "--runs: bad value \" [2J?\"; expected an integer from 1 to 1000000");
  const std::string dashes(5000, '-');
  EXPECT_EQ(error_of({dashes.c_str()}),
            "unknown option " + std::string(60, '-') + "...; --help lists the options");
}

TEST(Options, APeriodReplacesTheTimeLimit) {
  SolverOptions options;
  std::string error;
  ASSERT_TRUE(parse({"--period", "0.2"}, options, error));
  EXPECT_EQ(options.planner.period, 0.2);
  EXPECT_EQ(options.planner.time_limit, 0.2);
  SolverOptions both;
  EXPECT_FALSE(parse({"--period", "0.2", "--time", "0.1"}, both, error));
  EXPECT_NE(error.find("leave out --time"), std::string::npos) << error;
}

TEST(Options, ATrialLimitReplacesTheTimeLimit) {
  SolverOptions timed, counted;
  std::string error;
  ASSERT_TRUE(parse({}, timed, error));
  EXPECT_EQ(timed.planner.time_limit, 0.1);
  ASSERT_TRUE(parse({"--trials", "5"}, counted, error));
  EXPECT_TRUE(std::isinf(counted.planner.time_limit));
}

TEST(Options, GpuModeKeepsMoreInFlight) {
  SolverOptions options;
  std::string error;
  ASSERT_TRUE(parse({}, options, error));
  EXPECT_EQ(options.planner.in_flight, 1U);
  ASSERT_TRUE(parse({"--mode", "gpu"}, options, error));
  EXPECT_EQ(options.planner.in_flight, 64U);
  ASSERT_TRUE(parse({"--in-flight", "7", "--mode", "gpu", "--device", "cuda:2"}, options, error));
  EXPECT_EQ(options.planner.in_flight, 7U);
  EXPECT_EQ(options.device, DeviceKind::kCuda);
  EXPECT_EQ(options.device_index, 2);
  for (const char* bad : {"gpu", "cuda:", "cuda:x", "cuda2"}) EXPECT_NE(error_of({"--device", bad}), "");
  EXPECT_NE(error_of({"--in-flight", "0"}), "");
}

TEST(Options, ThreadsHaveATrialEach) {
  std::string error;
  SolverOptions options;
  ASSERT_TRUE(parse({"--mode", "parallel"}, options, error));
  EXPECT_EQ(options.planner.in_flight, options.planner.threads);
  ASSERT_TRUE(parse({"--mode", "parallel", "--threads", "6", "--in-flight", "2"}, options, error));
  EXPECT_EQ(options.planner.threads, 6U);
  EXPECT_EQ(options.planner.in_flight, 6U);
  ASSERT_TRUE(parse({"--mode", "despot"}, options, error));
  EXPECT_EQ(options.planner.threads, 1U);
  EXPECT_EQ(error_of({"--mode", "gpu", "--threads", "2"}),
            "--threads: mode gpu searches with one; modes parallel, hyp and pomcp with several");
  EXPECT_NE(error_of({"--mode", "parallel", "--threads", "0"}), "");
}

TEST(Options, PomcpExploresByItself) {
  std::string error;
  SolverOptions options;
  ASSERT_TRUE(parse({"--mode", "pomcp"}, options, error)) << error;
  EXPECT_EQ(options.planner.threads, 1U);
  EXPECT_EQ(options.planner.in_flight, 1U);
  EXPECT_EQ(options.planner.exploration, 0.3);
  ASSERT_TRUE(parse({"--mode", "pomcp", "--threads", "3", "--exploration", "0"}, options, error)) << error;
  EXPECT_EQ(options.planner.threads, 3U);
  EXPECT_EQ(options.planner.exploration, 0.0);
  ASSERT_TRUE(parse({"--mode", "pomcp", "--device", "cuda"}, options, error)) << error;
  EXPECT_EQ(options.planner.in_flight, 64U);
  ASSERT_TRUE(parse({"--mode", "despot"}, options, error)) << error;
  EXPECT_EQ(options.planner.exploration, 0.0);
  EXPECT_EQ(error_of({"--mode", "pomcp", "--pruning", "0.1"}), "--pruning: mode pomcp has no regularisation");
}

TEST(Options, NamesWhatIsWrong) {
  EXPECT_EQ(error_of({"--rusn", "3"}), "unknown option --rusn; --help lists the options");
  EXPECT_EQ(error_of({"--runs", "many"}),
            "--runs: bad value \"many\"; expected an integer from 1 to 1000000");
  EXPECT_EQ(error_of({"--runs"}), "--runs needs a value: an integer from 1 to 1000000");
  EXPECT_EQ(error_of({"--seed", "-1"}), "--seed: bad value \"-1\"; expected an integer from 0 (64 bits)");
  EXPECT_EQ(error_of({"--time", "0"}), "--time: bad value \"0\"; expected a number from 0.0001 to 1e+06");
  EXPECT_EQ(error_of({"--mode", "fast"}),
            "--mode: bad value \"fast\"; expected despot, parallel, gpu, hyp, pomcp, rollout or default");
  EXPECT_EQ(error_of({"--quiet=1"}), "--quiet takes no value");
  for (const char* bad : {"-1", "1x", "", "nan", "1e9"}) EXPECT_NE(error_of({"--time", bad}), "");
  EXPECT_NE(error_of({"--xi", "1.5"}), "");
  EXPECT_EQ(error_of({"--exploration", "-0.1"}),
            "--exploration: bad value \"-0.1\"; expected a number from 0 to 1000");
  for (const char* bad : {"nan", "inf", "", "x"}) EXPECT_NE(error_of({"--exploration", bad}), "");
  EXPECT_NE(error_of({"--seed", "99999999999999999999999"}), "");
}

TEST(Options, HelpNamesEveryOptionAndTheParams) {
  const std::string text = help_text(testing::tiger_descriptor(), "tiger");
  for (const char* name : {"--mode", "--time", "--trials", "--particles", "Examples:", "hearing"}) {
    EXPECT_NE(text.find(name), std::string::npos) << name;
  }
}

SolverOptions with_settings(const char* text, std::vector<const char*> words = {}) {
  SolverOptions options;
  std::string error;
  words.insert(words.end(), {"--settings", text});
  EXPECT_TRUE(parse(words, options, error)) << error;
  return options;
}

TEST(Options, SettingsGiveOptionsAndParams) {
  const SolverOptions options = with_settings(
      R"({"options": {"mode": "pomcp", "scenarios": 70, "xi": 0.5, "require-gpu": true, "signature": false},
          "params": {"sure": 0.75}, "found": {"by": "tune"}})");
  EXPECT_EQ(options.planner.mode, Mode::kPomcp);
  EXPECT_EQ(options.planner.scenarios, 70U);
  EXPECT_EQ(options.planner.target_ratio, 0.5);
  EXPECT_TRUE(options.require_gpu);
  EXPECT_FALSE(options.planner.signature);
  EXPECT_EQ(options.plan_params, R"({"sure":0.75})");
  EXPECT_EQ(with_settings("{}").plan_params, "");
}

TEST(Options, WhatIsGivenGoesBeforeSettings) {
  const char* const text = R"({"options": {"mode": "despot", "scenarios": 70, "trials": 5, "depth": 8}})";
  const SolverOptions options = with_settings(text, {"--mode", "rollout", "--scenarios=9", "--time=0.5"});
  EXPECT_EQ(options.planner.mode, Mode::kRollout);
  EXPECT_EQ(options.planner.scenarios, 9U);
  EXPECT_EQ(options.planner.depth, 8);
  EXPECT_EQ(options.planner.time_limit, 0.5);
  EXPECT_EQ(options.planner.trial_limit, UINT64_MAX) << "another budget replaces that of the settings";
}

TEST(Options, WrongSettingsAreRefused) {
  for (const auto& [text, says] : std::vector<std::pair<const char*, const char*>>{
           {"/nonexistent/file.json", "--settings: /nonexistent/file.json: cannot be read"},
           {"/", "--settings: /: cannot be read"},
           {"{", "not valid JSON"},
           {"{}[]", "not valid JSON"},
           {R"({"options": 3})", R"("options": expected an object, found 3)"},
           {R"({"params": [3]})", R"("params": expected an object)"},
           {R"({"options": {"scenario": 3}})", R"(no setting is named "scenario"; the settings are: mode)"},
           {R"({"options": {"runs": 3}})", R"(no setting is named "runs")"},
           {R"({"options": {"settings": "{}"}})", R"(no setting is named "settings")"},
           {R"({"options": {"scenarios": 0}})", R"("scenarios": bad value 0; expected an integer from 1)"},
           {R"({"options": {"scenarios": [3]}})", R"("scenarios": bad value [3])"},
           {R"({"options": {"scenarios": true}})", R"("scenarios": bad value true)"},
           {R"({"options": {"require-gpu": 1}})", "expected true or false"}}) {
    const std::string error = error_of({"--settings", text});
    EXPECT_NE(error.find(says), std::string::npos) << error;
  }
  const std::string deep = "{\"params\": " + std::string(100000, '[');
  EXPECT_NE(error_of({"--settings", deep.c_str()}).find("nested deeper"), std::string::npos);
}

}  // namespace
}  // namespace hypgen
