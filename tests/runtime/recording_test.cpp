// SPDX-License-Identifier: Apache-2.0
#include "hypgen/solver/recording.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "embedded_rocks.hpp"
#include "hypgen/solver/solver_main.hpp"

namespace hypgen {
namespace {

int solve(std::vector<std::string> words) {
  words.insert(words.begin(), "solver");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  return solver_main(testing::rocks(), static_cast<int>(arguments.size()), arguments.data());
}

std::vector<nlohmann::json> lines_of(const std::string& file) {
  std::vector<nlohmann::json> lines;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

std::vector<nlohmann::json> recorded(std::vector<std::string> words) {
  // Tests run side by side.
  const std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  const std::string file = ::testing::TempDir() + "record_" + test + ".jsonl";
  for (const char* const word :
       {"--runs", "1", "--steps", "2", "--particles", "100", "--quiet", "--record", file.c_str()})
    words.emplace_back(word);
  EXPECT_EQ(solve(words), 0);
  return lines_of(file);
}

std::size_t size_of(const nlohmann::json& node) {
  std::size_t size = 1;
  for (const char* const kind : {"actions", "groups"}) {
    if (!node.contains(kind)) continue;
    for (const nlohmann::json& child : node[kind]) size += size_of(child);
  }
  return size;
}

TEST(Recording, TellsStatesBeliefsAndTrees) {
  const std::vector<nlohmann::json> lines = recorded({"--mode", "despot", "--trials", "50"});
  EXPECT_EQ(lines[0]["type"], "recording");
  EXPECT_EQ(lines[0]["variables"].size(), 3U);
  EXPECT_EQ(lines[0]["options"]["trials"], 50);
  EXPECT_EQ(lines[1]["type"], "start");
  for (const nlohmann::json& step : lines) {
    if (step["type"] != "step") continue;
    EXPECT_EQ(step["state"]["good"].size(), 3U);
    EXPECT_EQ(step["sampled"]["good"].size(), Recording::kSamples);
    EXPECT_EQ(step["marginals"].size(), 3U);
    EXPECT_TRUE(step["default_action"].is_string());
    EXPECT_EQ(size_of(step["tree"]), step["tree_shown"]);
    EXPECT_LE(step["tree_shown"], step["tree_total"]);
  }
  EXPECT_EQ(lines.back()["type"], "episode");
  EXPECT_TRUE(lines.back()["state"].contains("x"));
}

TEST(Recording, CutsATreeToItsMostVisitedNodes) {
  const std::vector<nlohmann::json> lines = recorded({"--mode", "despot", "--trials", "300"});
  const nlohmann::json& step = lines[2];
  EXPECT_LE(step["tree_shown"], 5000);
  EXPECT_LT(step["tree_shown"], step["tree_total"]);
  EXPECT_EQ(size_of(step["tree"]), step["tree_shown"]);
}

TEST(Recording, LeavesOutWhatAModeLacks) {
  for (const char* const mode : {"default", "rollout"}) {
    const nlohmann::json step = recorded({"--mode", mode, "--trials", "20"})[2];
    EXPECT_TRUE(step["tree"].is_null());
    EXPECT_EQ(step["tree_total"], 0);
  }
  EXPECT_TRUE(recorded({"--mode", "default"})[2]["sampled"].is_null());
}

TEST(Recording, WorksWithThreadsWeightsAndPomcp) {
  const std::vector<std::vector<std::string>> ways = {{"--mode", "parallel", "--threads", "2"},
                                                      {"--mode", "despot", "--observations", "weighted"},
                                                      {"--mode", "pomcp"}};
  for (std::vector<std::string> words : ways) {
    words.insert(words.end(), {"--trials", "50"});
    const nlohmann::json step = recorded(words)[2];
    EXPECT_EQ(size_of(step["tree"]), step["tree_shown"]);
    for (const nlohmann::json& action : step["tree"]["actions"]) {
      double share = 0.0;
      for (const nlohmann::json& group : action["groups"]) {
        EXPECT_NE(group["terminal"].get<bool>(), group.contains("seen"));
        share += group["share"].get<double>();
      }
      EXPECT_NEAR(share, 1.0, 1e-9);
    }
  }
}

TEST(Recording, ChangesNothingOfTheRun) {
  const std::string plain = ::testing::TempDir() + "plain.jsonl";
  ASSERT_EQ(solve({"--mode", "despot", "--trials", "50", "--runs", "1", "--steps", "2", "--particles", "100",
                   "--quiet", "--json", plain}),
            0);
  std::vector<nlohmann::json> expected;
  for (const nlohmann::json& line : lines_of(plain))
    if (line["type"] == "step") expected.push_back(line);
  std::size_t i = 0;
  for (const nlohmann::json& step : recorded({"--mode", "despot", "--trials", "50"})) {
    if (step["type"] != "step") continue;
    for (const char* const name : {"action", "reward", "lower", "upper", "trials", "observation"})
      EXPECT_EQ(step[name], expected.at(i)[name]);
    ++i;
  }
  EXPECT_EQ(i, expected.size());
}

TEST(Recording, RefusesWhatItCannotWriteTo) {
  EXPECT_EQ(solve({"--record", "-"}), 2);
  EXPECT_EQ(solve({"--serve", "--record", "x"}), 2);
  EXPECT_EQ(solve({"--record", "/nonexistent/x.jsonl"}), 1);
  EXPECT_EQ(solve({"--record", "/dev/full", "--quiet", "--runs", "1", "--trials", "5"}), 1);
}

}  // namespace
}  // namespace hypgen
