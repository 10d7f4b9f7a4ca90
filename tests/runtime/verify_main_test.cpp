// SPDX-License-Identifier: Apache-2.0
// The program that checks a model's code: what its options ask for, and how it ends.
#include "hypgen/verify/verify_main.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hypgen/verify/verifiable_instance.hpp"
#include "test_solvers.hpp"

namespace hypgen::testing {
namespace {

struct Ended {
  int code;
  std::string out, err;
};

Ended run(std::vector<std::string> words, const VerifiableModel& model) {
  words.insert(words.begin(), "tiger_verify");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  const int code = verify_main(model, static_cast<int>(arguments.size()), arguments.data());
  return {code, ::testing::internal::GetCapturedStdout(), ::testing::internal::GetCapturedStderr()};
}

Ended run(std::vector<std::string> words) {
  return run(std::move(words), make_verifiable<Tiger>(tiger_descriptor()));
}

TEST(VerifyMain, ComparesStepsUnlessToldOtherwise) {
  const Ended ended = run({"--lanes", "10", "--steps", "7", "--warps", "2", "--threads", "2", "--json", "-"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  const auto line = nlohmann::json::parse(ended.out.substr(0, ended.out.find('\n')));
  EXPECT_EQ(line["check"], "schedule");
  EXPECT_EQ(line["variant"], "2 warps");
  EXPECT_EQ(line["steps"], 70);
}

TEST(VerifyMain, ATraceHasARowForEachLaneAndStep) {
  const std::string file = ::testing::TempDir() + "trace.bin";
  ASSERT_EQ(run({"--trace", file, "--trace-scenarios", "3", "--trace-steps", "5"}).code, 0);
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  EXPECT_EQ(in.tellg(), 3 * 5 * (1 + 10 + 2) * 8);
  const Ended ended = run({"--trace", "/nonexistent/folder/file"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_EQ(ended.err, "Tiger: /nonexistent/folder/file: cannot be written: No such file or directory\n");
}

TEST(VerifyMain, SamplesBoundsTheSameWithAnyThreads) {
  const Ended one = run({"--check-bounds", "100", "--threads", "1", "--seed", "3", "--json", "-"});
  EXPECT_EQ(one.code, 0) << one.err;
  EXPECT_EQ(nlohmann::json::parse(one.out)["bounds"]["upper"]["beliefs"], 100);
  EXPECT_EQ(run({"--check-bounds", "100", "--threads", "3", "--seed", "3", "--json", "-"}).out, one.out);
}

TEST(VerifyMain, ExitCodesTellMistakesApart) {
  EXPECT_EQ(run({"--mode", "despot"}).err, "Tiger: unknown option --mode; --help lists the options\n");
  EXPECT_EQ(run({"--param", "/nonexistent.json"}).code, 2);
  EXPECT_EQ(run({"--threads", "0"}).code, 2);
  EXPECT_EQ(run({"--json", "/nonexistent/x.jsonl"}).code, 1);
  const Ended two = run({"--check-bounds", "9", "--check-beliefs", "9"});
  EXPECT_EQ(two.code, 2);
  EXPECT_NE(two.err.find("run one after the other"), std::string::npos) << two.err;
  EXPECT_NE(run({"--check-beliefs", "9"}).err.find("no hidden variables"), std::string::npos);
  EXPECT_NE(run({"--belief", "factored"}).err.find("does not factor"), std::string::npos);
}

TEST(VerifyMain, HelpNamesOptionsAndParams) {
  const Ended ended = run({"--help"});
  EXPECT_EQ(ended.code, 0);
  for (const char* name : {"--lanes", "--check-bounds", "--check-beliefs", "--trace", "Examples:", "hearing"})
    EXPECT_NE(ended.out.find(name), std::string::npos) << name;
  EXPECT_EQ(ended.out.find("--mode"), std::string::npos);
  EXPECT_EQ(run({"--version"}).out, "Tiger (model 0, descriptor 1)\n");
}

}  // namespace
}  // namespace hypgen::testing
