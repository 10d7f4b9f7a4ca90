// SPDX-License-Identifier: Apache-2.0
#include "hypgen/embed/agent.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "hypgen/math/float_bits.hpp"
#include "hypgen/model/value_text.hpp"
#include "hypgen/solver/step_details.hpp"
#include "test_solvers.hpp"

namespace hypgen {
namespace {

using Values = std::vector<std::int32_t>;

std::string reading_name(std::int32_t value) {
  return value == 0 ? "nothing" : value == 1 ? "looks_good" : value == 2 ? "looks_bad" : "?";
}

Span<const std::int32_t> view(const Values& values) { return {values.data(), values.size()}; }

EmbeddedModel rocks() {
  EmbeddedModel model{testing::rock_sample_descriptor<4, 3>(), {}, {}};
  model.visible = {{"x", {}, ValueKind::kInt, 0, 3}, {"y", {}, ValueKind::kInt, 0, 3}};
  model.seen = {{"reading", {}, ValueKind::kNamed, 0, 2, reading_name}};
  model.descriptor.hidden_variables = {{"good", 2, 3, false}};
  model.hidden = {{"good", {3}, ValueKind::kBool, 0, 1}};
  return model;
}

EmbeddedModel tiger() {
  EmbeddedModel model{testing::tiger_descriptor(), {}, {}};
  model.seen = {{"heard", {}, ValueKind::kBool, 0, 1}};
  return model;
}

constexpr const char* kFew = "mode=despot trials=200 scenarios=50 particles=200 memory=64";

class AgentTest : public ::testing::Test {
 protected:
  std::unique_ptr<Agent> make(EmbeddedModel model, const std::string& settings = kFew,
                              const std::string& params = "") {
    error.clear();
    return Agent::create(std::move(model), {settings, params}, status, error);
  }

  Status status = Status::kOk;
  std::string error;
  Decision decision;
};

TEST_F(AgentTest, PlansAndLearns) {
  const auto agent = make(tiger());
  ASSERT_TRUE(agent) << error;
  ASSERT_EQ(agent->reset(Span<const std::int32_t>(), 0, error), Status::kOk);
  EXPECT_NE(agent->plan(0.0, decision, error), Status::kWrongArgument);
  EXPECT_EQ(decision.action, 0);
  std::vector<std::uint64_t> key;
  ASSERT_EQ(agent->encode(R"({"heard": true})", key, error), Status::kOk);
  for (int i = 0; i < 3; ++i) ASSERT_EQ(agent->update(0, {key.data(), 1}, error), Status::kOk);
  agent->plan(0.0, decision, error);
  EXPECT_EQ(decision.action, 1);
  EXPECT_EQ(agent->step(), 3);
  const auto& hidden = agent->model().descriptor.hidden_variables;
  if (!hidden.empty()) {
    double probability = 0.0;
    ASSERT_EQ(
        agent->probability(entry_name(agent->model().descriptor, hidden[0], 0), "1", probability, error),
        Status::kOk);
    EXPECT_GT(probability, 0.9);
  }
}

// The same settings and episode give the decision of the program's planner.
TEST_F(AgentTest, DecidesAsTheSolverDoes) {
  const auto agent = make(rocks(), "mode=despot trials=100 scenarios=100 particles=1000 memory=64");
  ASSERT_TRUE(agent) << error;
  ASSERT_EQ(agent->reset("{}", 0, error), Status::kOk);
  agent->plan(0.0, decision, error);
  testing::Solver solver(testing::rock_sample_descriptor<4, 3>(), testing::trials(100));
  const Decision expected = solver.plan();
  EXPECT_EQ(decision.action, expected.action);
  EXPECT_EQ(decision.lower, expected.lower);
  EXPECT_EQ(decision.upper, expected.upper);
}

TEST_F(AgentTest, RefusesWrongSettings) {
  for (const char* wrong : {"scenarios=0",
                            "scenarios=20000",
                            "depth=0",
                            "depth=20000",
                            "particles=0",
                            "time=nan",
                            "time=-1",
                            "time=0",
                            "mode=fast",
                            "runs=3",
                            "json=x",
                            "help",
                            "trials=0",
                            "memory=0",
                            "threads=0",
                            "bogus",
                            "belief=visible",
                            "pruning=1 mode=pomcp",
                            "period=0.1 time=0.1",
                            "period=0",
                            "threads=2 mode=despot",
                            "scenarios",
                            "=",
                            "--mode=despot"}) {
    EXPECT_FALSE(make(tiger(), wrong)) << wrong;
    EXPECT_EQ(status, Status::kWrongArgument) << wrong;
    EXPECT_FALSE(error.empty()) << wrong;
  }
  EXPECT_FALSE(make(tiger(), kFew, "{"));
  const std::string opened(1000000, '['), closed(1000000, ']');
  EXPECT_FALSE(make(tiger(), kFew, R"({"bogus": )" + opened + closed + "}"));
  EXPECT_FALSE(make(tiger(), kFew, R"({"bogus": 1})"));
  EXPECT_EQ(status, Status::kWrongArgument);
}

TEST_F(AgentTest, RequiresAGpuInVain) {
  EXPECT_FALSE(make(tiger(), "mode=gpu require-gpu"));
  EXPECT_EQ(status, Status::kNoGpu);
  EXPECT_FALSE(error.empty());
  const auto agent = make(tiger(), "mode=gpu trials=10 memory=64");
  ASSERT_TRUE(agent);
  EXPECT_EQ(agent->device(), "cpu");
  EXPECT_FALSE(agent->device_problem().empty());
}

// Two thousand scenarios and a depth of 300 reach tree and evaluator alike.
TEST_F(AgentTest, SizesFollowFromTheSettings) {
  const auto agent = make(tiger(), "mode=despot trials=20 scenarios=2000 depth=300");
  ASSERT_TRUE(agent) << error;
  ASSERT_EQ(agent->reset("{}", 0, error), Status::kOk);
  EXPECT_EQ(agent->plan(0.0, decision, error), Status::kTrialLimit);
  EXPECT_GT(decision.expansions, 0U);
}

TEST_F(AgentTest, LittleMemoryEndsInAStatus) {
  const auto agent = make(rocks(), "mode=despot trials=1000000 scenarios=500 particles=100 memory=1");
  ASSERT_TRUE(agent) << error;
  ASSERT_EQ(agent->reset("{}", 0, error), Status::kOk);
  const Status found = agent->plan(5.0, decision, error);
  EXPECT_TRUE(found == Status::kMemoryFull || found == Status::kConverged) << status_name(found);
  EXPECT_GE(decision.action, 0);
  EXPECT_FALSE(make(tiger(), "memory=1000000 mode=despot"));
  EXPECT_EQ(status, Status::kNoMemory);
}

TEST_F(AgentTest, RefusesCallsBeforeReset) {
  const auto agent = make(tiger());
  ASSERT_TRUE(agent);
  const std::uint64_t key = 0;
  std::string text;
  double number = 0.0;
  EXPECT_EQ(agent->plan(0.1, decision, error), Status::kWrongArgument);
  EXPECT_EQ(agent->update(0, {&key, 1}, error), Status::kWrongArgument);
  EXPECT_EQ(agent->describe_belief(text, error), Status::kWrongArgument);
  EXPECT_EQ(agent->probability("x", "1", number, error), Status::kWrongArgument);
}

TEST_F(AgentTest, RefusesWrongArguments) {
  const auto agent = make(rocks());
  ASSERT_TRUE(agent) << error;
  for (const Values& wrong : {Values{-5, 0}, Values{0, 4}, Values{0}, Values{0, 0, 0}})
    EXPECT_EQ(agent->reset(view(wrong), 0, error), Status::kWrongArgument);
  for (const char* wrong : {"", "[", "[]", R"({"x": -5})", R"({"x": "1"})", R"({"x": 1.5})", R"({"z": 1})",
                            R"({"x": [1]})", R"({"x": 1e300})", R"({"x": null})"})
    EXPECT_EQ(agent->reset(wrong, 0, error), Status::kWrongArgument) << wrong;
  const std::string opened(1000000, '['), closed(1000000, ']');
  EXPECT_EQ(agent->reset(opened, 0, error), Status::kWrongArgument);
  const std::string hidden = R"({"x": [")" + closed + R"(\\", )" + opened + closed + "]}";
  EXPECT_EQ(agent->reset(hidden, 0, error), Status::kWrongArgument);
  EXPECT_EQ(agent->reset(R"({"x": 1})", std::uint64_t{1} << 44, error), Status::kWrongArgument);
  ASSERT_EQ(agent->reset(R"({"x": 1})", 0, error), Status::kOk);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double wrong : {nan, -1.0, 1e9, -nan, HUGE_VAL})
    EXPECT_EQ(agent->plan(wrong, decision, error), Status::kWrongArgument) << wrong;
  const std::uint64_t good[] = {0, 0};
  for (const int wrong : {-1, 99, 8, INT32_MIN})
    EXPECT_EQ(agent->update(wrong, {good, 1}, error), Status::kWrongArgument);
  for (const std::uint64_t wrong : {std::uint64_t{3}, UINT64_MAX})
    EXPECT_EQ(agent->update(0, {&wrong, 1}, error), Status::kWrongArgument);
  EXPECT_EQ(agent->update(0, {good, 2}, error), Status::kWrongArgument);
  EXPECT_EQ(agent->update(0, {}, error), Status::kWrongArgument);
  EXPECT_EQ(agent->step(), 0);
  int action = 0;
  EXPECT_EQ(agent->find_action("fly", action, error), Status::kWrongArgument);
  double number = 0.0;
  EXPECT_EQ(agent->probability("moon", "1", number, error), Status::kWrongArgument);
}

TEST_F(AgentTest, RefusesAnActionThatIsNotLegal) {
  const auto agent = make(rocks());
  ASSERT_TRUE(agent);
  const std::uint64_t key = 0;
  int sample = 0, refused = 0;
  ASSERT_EQ(agent->find_action("sample", sample, error), Status::kOk);
  for (int x = 0; x < 4; ++x) {
    for (int y = 0; y < 4; ++y) {
      ASSERT_EQ(agent->reset(view({x, y}), 0, error), Status::kOk);
      refused += agent->update(sample, {&key, 1}, error) == Status::kWrongArgument ? 1 : 0;
    }
  }
  EXPECT_EQ(refused, 16 - 3);  // one cell for each rock
}

// A model whose bound may be wrong, whose actions end, and whose episode ends in its third step.
TEST_F(AgentTest, TellsWhatIsWrongWithTheModel) {
  const auto mishaps = [](double upper, int illegal_from) {
    EmbeddedModel model{testing::mishaps_descriptor(upper, illegal_from), {}, {}};
    model.visible = {{"count", {}, ValueKind::kInt, 0, 9}};
    model.seen = {{"hidden", {}, ValueKind::kBool, 0, 1}};
    return model;
  };
  const auto planned = [&](double upper, int illegal_from) {
    const auto agent = make(mishaps(upper, illegal_from));
    EXPECT_TRUE(agent) << error;
    EXPECT_EQ(agent->reset("{}", 0, error), Status::kOk);
    return agent->plan(0.0, decision, error);
  };
  EXPECT_EQ(planned(10.0, 9), Status::kConverged);
  EXPECT_EQ(planned(std::numeric_limits<double>::quiet_NaN(), 9), Status::kModelNan);
  EXPECT_EQ(decision.action, 0);
  EXPECT_EQ(planned(-1.0, 9), Status::kCrossedBounds);
  EXPECT_GE(decision.action, 0);
  EXPECT_EQ(planned(10.0, 0), Status::kNoLegalAction);
  EXPECT_EQ(decision.action, -1);
  const auto agent = make(mishaps(10.0, 9));
  ASSERT_EQ(agent->reset(R"({"count": 2})", 0, error), Status::kOk);
  const std::uint64_t key = 0;
  EXPECT_EQ(agent->update(0, {&key, 1}, error), Status::kAllParticlesTerminal);
}

TEST_F(AgentTest, WantsToKnowWhatTheModelDraws) {
  EmbeddedModel model = rocks();
  model.visible[1].drawn = true;
  const auto agent = make(std::move(model));
  ASSERT_TRUE(agent);
  EXPECT_EQ(agent->reset("{}", 0, error), Status::kWrongArgument);
  EXPECT_NE(error.find("y: "), std::string::npos);
  EXPECT_EQ(agent->reset(R"({"y": 2})", 0, error), Status::kOk);
}

TEST_F(AgentTest, TellsOfAnImpossibleObservation) {
  const auto agent = make(rocks());
  ASSERT_TRUE(agent);
  ASSERT_EQ(agent->reset("{}", 0, error), Status::kOk);
  int check = 0;
  ASSERT_EQ(agent->find_action(agent->model().descriptor.action_names[5], check, error), Status::kOk);
  EXPECT_EQ(check, 5);
  const std::uint64_t nothing = 0;  // a check always reads something
  EXPECT_EQ(agent->update(check, {&nothing, 1}, error), Status::kImpossibleObservation);
  EXPECT_NE(agent->plan(0.0, decision, error), Status::kWrongArgument);
  EXPECT_GE(decision.action, 0);
}

TEST_F(AgentTest, ShortTimeStillDecides) {
  const auto agent = make(rocks(), "mode=despot scenarios=500 particles=5000 memory=64");
  ASSERT_TRUE(agent);
  ASSERT_EQ(agent->reset("{}", 0, error), Status::kOk);
  const Status found = agent->plan(1e-9, decision, error);
  EXPECT_EQ(found, Status::kDeadlineDefault) << status_name(found);
  EXPECT_GE(decision.action, 0);
}

TEST(KeyCodec, HasOneOrderForKeysOfAnyLength) {
  const std::vector<ValueField> narrow = {{"a", {}, ValueKind::kInt, -1, 3},
                                          {"b", {2}, ValueKind::kBool, 0, 1}};
  const KeyCodec one(narrow, 1);
  std::vector<std::uint64_t> key;
  one.encode(view({3, 1, 0}), key);
  EXPECT_EQ(key[0], 4U * 4 + 2);
  std::vector<ValueField> wide = narrow;
  wide.push_back({"c", {3}, ValueKind::kFloat, -HUGE_VAL, HUGE_VAL});
  wide.push_back({"d", {}, ValueKind::kInt, INT32_MIN, INT32_MAX});
  const KeyCodec several(wide, 3);
  const auto half = static_cast<std::int32_t>(math::to_bits(0.5F));
  const Values values = {2, 0, 1, half, 0, half, -7};
  several.encode(view(values), key);
  KeyReader reader({key.data(), key.size()});  // as generated code reads
  for (const std::uint64_t digit : {3, 0, 1}) EXPECT_EQ(reader.take(digit == 3 ? 5 : 2), digit);
  Values back;
  ASSERT_TRUE(several.decode({key.data(), key.size()}, back));
  EXPECT_EQ(back, values);
  std::vector<std::uint64_t> wrong = key;
  wrong[0] = UINT64_MAX;
  EXPECT_FALSE(several.decode({wrong.data(), wrong.size()}, back));
  EXPECT_FALSE(several.decode({key.data(), 2}, back));
  EXPECT_FALSE(one.decode({key.data(), 1}, back));
}

TEST(ValueText, ReadsWhatItWrites) {
  const std::vector<ValueField> fields = {{"on", {}, ValueKind::kBool, 0, 1},
                                          {"cell", {2, 2}, ValueKind::kInt, -3, 3},
                                          {"far", {}, ValueKind::kFloat, 0, 10},
                                          {"reading", {}, ValueKind::kNamed, 0, 2, reading_name}};
  const auto half = static_cast<std::int32_t>(math::to_bits(0.5F));
  const Values values = {1, -3, 0, 1, 3, half, 2};
  Values back(values.size());
  std::vector<bool> given;
  std::string error;
  ASSERT_TRUE(read_values(values_text(fields, values), fields, back, given, error)) << error;
  EXPECT_EQ(back, values);
  EXPECT_TRUE(read_values(R"({"cell": [[-3, 0], [1, 3]]})", fields, back, given, error)) << error;
  EXPECT_EQ(back, values);
  EXPECT_EQ(given, (std::vector<bool>{false, true, false, false}));
  EXPECT_FALSE(read_values(R"({"far": 11})", fields, back, given, error));
  EXPECT_EQ(error, "far: expected a number from 0.0 to 10.0, found 11");
  EXPECT_FALSE(read_values(R"({"reading": "looks"})", fields, back, given, error));
  const auto nan = static_cast<std::int32_t>(0x7FC00000);
  EXPECT_FALSE(check_values({fields[2]}, view({nan}), error));
  const ValueField any = {"any", {}, ValueKind::kFloat, -HUGE_VAL, HUGE_VAL};
  EXPECT_FALSE(check_values({any}, view({0x7F800000}), error));
  EXPECT_FALSE(read_values(R"({"any": 1e300})", {any}, back, given, error));
}

TEST(Describe, TellsAllThatACallerNeeds) {
  const auto json = nlohmann::json::parse(describe(rocks()));
  EXPECT_EQ(json["seen"][0]["values"][1], "looks_good");
  EXPECT_EQ(json["visible"][1]["high"], 3);
  EXPECT_EQ(json["actions"].size(), 8U);
}

}  // namespace
}  // namespace hypgen
