// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "factored_models.hpp"
#include "hypgen/math/float_bits.hpp"
#include "hypgen/solver/json_lines.hpp"
#include "hypgen/solver/model_instance.hpp"
#include "hypgen/solver/run_report.hpp"
#include "hypgen/solver/solver_main.hpp"
#include "hypgen/solver/step_details.hpp"
#include "test_solvers.hpp"

namespace hypgen {
namespace {

TEST(Statistics, MeansAndQuantiles) {
  Samples samples;
  EXPECT_EQ(samples.mean(), 0.0);
  for (const double value : {4.0, 1.0, 3.0, 2.0}) samples.add(value);
  EXPECT_DOUBLE_EQ(samples.mean(), 2.5);
  EXPECT_NEAR(samples.interval95(), 3.182 * 1.2909944 / 2.0, 1e-6);  // Student's t, 3 degrees of freedom
  EXPECT_EQ(samples.quantile(0.5), 2.0);
  EXPECT_EQ(samples.quantile(0.99), 4.0);
  EXPECT_EQ(samples.largest(), 4.0);
  EXPECT_EQ(histogram_median({0, 3, 0, 2}), 1.0);
}

int solve(const EmbeddedModel& model, std::vector<std::string> words) {
  words.insert(words.begin(), "solver");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  return solver_main(model, static_cast<int>(arguments.size()), arguments.data());
}

int solve(const ModelDescriptor& model, std::vector<std::string> words) {
  return solve(EmbeddedModel{model}, std::move(words));
}

std::vector<nlohmann::json> json_lines(const std::string& file) {
  std::vector<nlohmann::json> lines;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

TEST(JsonLines, TellTheWholeRun) {
  const std::string file = ::testing::TempDir() + "run.jsonl";
  ASSERT_EQ(
      solve(testing::rock_sample_descriptor<4, 3>(), {"--mode", "despot", "--runs", "2", "--trials", "20",
                                                      "--particles", "100", "--quiet", "--json", file}),
      0);
  const std::vector<nlohmann::json> lines = json_lines(file);
  EXPECT_EQ(lines.front()["type"], "run");
  EXPECT_EQ(lines.front()["version"], 1);
  EXPECT_EQ(lines.front()["trials"], 20);
  EXPECT_EQ(lines.back()["type"], "summary");
  double total = 0.0;
  std::size_t steps = 0;
  for (const nlohmann::json& line : lines) {
    if (line["type"] == "step") {
      ++steps;
      EXPECT_LE(line["lower"].get<double>(), line["upper"].get<double>());
      EXPECT_EQ(line["observation"].is_null(), line["terminal"].get<bool>());
    }
    if (line["type"] == "episode") {
      EXPECT_EQ(line["status"], "terminal");
      EXPECT_EQ(line["success"], true);
      total += line["discounted_return"].get<double>();
    }
  }
  EXPECT_EQ(lines.back()["steps"], steps);
  EXPECT_NEAR(lines.back()["discounted_return"].get<double>(), total / 2, 1e-12);
}

TEST(JsonLines, TellWhatIsVisibleAtTheEnd) {
  const std::string file = ::testing::TempDir() + "end.jsonl";
  ModelDescriptor model = testing::rock_sample_descriptor<4, 3>();
  const std::vector<std::string> words = {"--mode", "default", "--runs", "1", "--quiet", "--json", file};
  const auto visible = [&] {
    EXPECT_EQ(solve(model, words), 0);
    for (const nlohmann::json& line : json_lines(file)) {
      if (line["type"] == "episode") return line["visible"];
    }
    return nlohmann::json();
  };
  EXPECT_EQ(visible(), nlohmann::json::object());
  model.visible_variables = {{"place", 2, true, false}};
  const nlohmann::json place = visible()["place"];
  ASSERT_EQ(place.size(), 2U);
  EXPECT_EQ(place[0], 3);  // the last column
  model.visible_variables = {{"x", 1, false, false}, {"y", 1, false, true}};
  EXPECT_EQ(visible()["x"], place[0]);
  EXPECT_EQ(visible()["y"].get<float>(), math::from_bits(place[1].get<std::uint32_t>()));
}

TEST(JsonLines, TellWhatIsSeenAtTheStart) {
  const std::string file = ::testing::TempDir() + "start.jsonl";
  ModelDescriptor model = testing::rock_sample_descriptor<4, 3>();
  const std::vector<std::string> words = {"--mode",      "default", "--belief", "particle", "--runs", "2",
                                          "--particles", "10",      "--quiet",  "--json",   file};
  const auto starts = [&] {
    std::vector<nlohmann::json> found;
    for (const nlohmann::json& line : json_lines(file)) {
      if (line["type"] == "start") found.push_back(line);
    }
    return found;
  };
  ASSERT_EQ(solve(model, words), 0);
  EXPECT_TRUE(starts().empty());
  model.first_observation_name = [](const std::int32_t* visible) { return std::to_string(visible[1]); };
  ASSERT_EQ(solve(model, words), 0);
  ASSERT_EQ(starts().size(), 2U);
  const nlohmann::json second = starts()[1];
  EXPECT_EQ(second["episode"], 1);
  EXPECT_EQ(second["observation"], "2");  // of x and y
  EXPECT_EQ(second["belief"], "ok");
  EXPECT_NEAR(second["effective_sample_size"].get<double>(), 10.0, 1e-9);
}

TEST(JsonLines, TellOfUnitsWithParticles) {
  const std::string file = ::testing::TempDir() + "units.jsonl";
  ModelDescriptor model = make_descriptor<testing::CoinAndLevel>();
  model.action_names = {"look", "end"};
  model.observation_name = [](KeyWords key) { return std::to_string(key[0]); };
  ASSERT_EQ(solve(model, {"--mode", "despot", "--trials", "5", "--runs", "1", "--steps", "3", "--particles",
                          "400", "--quiet", "--json", file}),
            0);
  const nlohmann::json step = json_lines(file)[1];
  EXPECT_EQ(step["particles"], nlohmann::json::array({400}));
  EXPECT_GE(step["effective"][0].get<double>(), 200.0);
  EXPECT_LE(step["distinct"][0].get<int>(), 10);
  EXPECT_EQ(step["surprise"], nlohmann::json::array({0.0}));  // there was no step before
  EXPECT_GE(step["update_seconds"].get<double>(), 0.0);
}

TEST(JsonLines, SayThatNoBeliefIsKeptWhereNothingReadsIt) {
  const std::string file = ::testing::TempDir() + "default.jsonl";
  std::vector<std::string> words = {"--mode", "default", "--runs", "3", "--quiet", "--json", file};
  const ModelDescriptor model = testing::rock_sample_descriptor<4, 3>();
  ASSERT_EQ(solve(model, words), 0);
  const std::vector<nlohmann::json> lines = json_lines(file);
  EXPECT_EQ(lines[1]["belief"], "not_kept");
  EXPECT_TRUE(lines[1]["effective_sample_size"].is_null());
  words.insert(words.end(), {"--belief", "particle"});
  ASSERT_EQ(solve(model, words), 0);
  const std::vector<nlohmann::json> kept = json_lines(file);
  EXPECT_EQ(kept[1]["belief"], "ok");
  EXPECT_EQ(kept.back()["discounted_return"], lines.back()["discounted_return"]);
}

TEST(JsonLines, TellHowManyThreadsSearched) {
  const std::string file = ::testing::TempDir() + "threads.jsonl";
  ASSERT_EQ(solve(testing::tiger_descriptor(), {"--mode", "parallel", "--threads", "3", "--runs", "1",
                                                "--steps", "2", "--trials", "20", "--quiet", "--json", file}),
            0);
  const std::vector<nlohmann::json> lines = json_lines(file);
  EXPECT_EQ(lines[0]["threads"], 3);
  EXPECT_EQ(lines[0]["in_flight"], 3);
  EXPECT_TRUE(lines[0]["lanes"].is_null());  // the model has none
  EXPECT_EQ(lines[1]["trials"], 20);
  EXPECT_EQ(lines[1]["late_threads"], 0);
}

TEST(JsonLines, TellWhatAStepWasDecidedByIfAskedTo) {
  const std::string file = ::testing::TempDir() + "details.jsonl";
  ModelDescriptor model = testing::tiger_descriptor();
  model.hidden_variables = {{"tiger", model.visible_count, 1, false}};
  model.hidden_value_name = [](int, std::int32_t value) { return value == 0 ? "left" : "right"; };
  std::vector<std::string> words = {"--mode",  "despot", "--trials", "50",     "--runs", "1",
                                    "--steps", "4",      "--quiet",  "--json", file};
  ASSERT_EQ(solve(model, words), 0);
  const std::vector<nlohmann::json> plain = json_lines(file);
  EXPECT_FALSE(plain[1].contains("marginals"));
  words.emplace_back("--details");
  ASSERT_EQ(solve(model, words), 0);
  const std::vector<nlohmann::json> lines = json_lines(file);
  for (std::size_t i = 1; i < 5; ++i) {
    const nlohmann::json& step = lines[i];
    EXPECT_EQ(step["lower"], plain[i]["lower"]);  // the search is the same
    ASSERT_EQ(step["marginals"].size(), 1U);
    EXPECT_EQ(step["marginals_left_out"], 0);
    const nlohmann::json& values = step["marginals"][0]["values"];
    EXPECT_GE(values[0]["probability"], values[1]["probability"]);
    EXPECT_NEAR(values[0]["probability"].get<double>() + values[1]["probability"].get<double>(), 1.0, 1e-9);
    std::uint64_t visits = 0;
    double upper = -1e9;
    for (const nlohmann::json& action : step["root"]) {
      EXPECT_LE(action["lower"], action["upper"]);
      visits += action["visits"].get<std::uint64_t>();
      upper = std::max(upper, action["upper"].get<double>());
    }
    EXPECT_EQ(step["root"][0]["action"], step["action_name"]);
    EXPECT_EQ(visits, step["trials"]);
    EXPECT_NEAR(upper, step["upper"].get<double>(), 1e-9);
  }
}

TEST(JsonLines, LeaveOutTheDetailsOfWhatIsNotKeptOrSearched) {
  const std::string file = ::testing::TempDir() + "no_details.jsonl";
  ASSERT_EQ(solve(testing::rock_sample_descriptor<4, 3>(),
                  {"--mode", "default", "--runs", "1", "--quiet", "--details", "--json", file}),
            0);
  const nlohmann::json step = json_lines(file)[1];
  EXPECT_TRUE(step["marginals"].empty());
  EXPECT_TRUE(step["root"].empty());
  EXPECT_EQ(solve(testing::tiger_descriptor(), {"--details"}), 2);
}

// A belief in one float and in many values.
class SpreadBelief final : public Belief {
 public:
  Status init(const std::int32_t*, std::uint64_t) override { return Status::kOk; }
  Status update(int, KeyWords) override { return Status::kOk; }
  void propagate(int, KeyWords) override {}
  void reserve(ScenarioBuffer&, std::size_t) const override {}
  void sample(StreamKey, std::uint32_t, std::size_t, ScenarioBuffer&) const override {}
  bool is_legal(int) const override { return true; }
  int default_action(StreamKey) const override { return 0; }
  void each_value(int variable, const TakeValue& take) const override {
    if (variable == 0) {
      for (const float value : {1.0F, 3.0F}) take(static_cast<std::int32_t>(math::to_bits(value)), 0.5);
    } else {
      for (int value = 0; value < 8; ++value) take(value, value == variable ? 0.3 : 0.1);
    }
  }
  void export_particles(ScenarioBuffer&, std::vector<double>&) const override {}
  bool import_particles(const ScenarioBuffer&, const std::vector<double>&) override { return false; }
  double effective_sample_size() const override { return 1.0; }
  std::size_t size() const override { return 1; }
};

TEST(StepDetails, AreMomentsOfFloatsAndLikelyValuesOfTheRest) {
  ModelDescriptor model = testing::tiger_descriptor();
  model.variable_names = {"x"};
  model.hidden_variables = {{"x", 0, 1, true}, {"y", 1, 150, false}};
  testing::Solver solver(model, testing::trials(1));
  const StepDetails details = step_details(model, SpreadBelief(), solver.planner, {});
  ASSERT_EQ(details.marginals.size(), StepDetails::kMostMarginals);
  EXPECT_EQ(details.marginals_left_out, 51U);
  EXPECT_TRUE(details.marginals[0].is_float);
  EXPECT_EQ(details.marginals[0].name, "x");
  EXPECT_DOUBLE_EQ(details.marginals[0].mean, 2.0);
  EXPECT_DOUBLE_EQ(details.marginals[0].deviation, 1.0);
  const Marginal& second = details.marginals[2];
  EXPECT_EQ(second.name, "y[1]");
  ASSERT_EQ(second.values.size(), StepDetails::kMostValues);
  EXPECT_EQ(second.values[0].first, "2");
  EXPECT_EQ(second.values[1].first, "0");
}

TEST(SolverMain, ExitCodesTellMistakesApart) {
  const ModelDescriptor model = testing::tiger_descriptor();
  EXPECT_EQ(solve(model, {"--bogus"}), 2);
  EXPECT_EQ(solve(model, {"--param", "/nonexistent.json"}), 2);
  EXPECT_EQ(solve(model, {"--json", "/nonexistent/x.jsonl"}), 1);
  EXPECT_EQ(solve(model, {"--version"}), 0);
}

}  // namespace
}  // namespace hypgen
