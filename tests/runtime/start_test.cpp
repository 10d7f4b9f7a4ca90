// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <string>
#include <vector>

#include "embedded_rocks.hpp"
#include "hypgen/episode/world.hpp"
#include "hypgen/episode/worlds.hpp"
#include "hypgen/model/start_text.hpp"
#include "hypgen/solver/solver_main.hpp"
#include "test_models.hpp"

namespace hypgen::testing {
namespace {

using State = std::array<std::int32_t, 5>;  // x, y and whether the rocks are good

StartValues read(const std::string& text) {
  StartValues start;
  std::string error;
  EXPECT_TRUE(read_start(text, rocks(), start, error)) << error;
  return start;
}

std::string refusal(const std::string& text) {
  StartValues start;
  std::string error;
  EXPECT_FALSE(read_start(text, rocks(), start, error)) << text;
  EXPECT_TRUE(start.values.empty());
  return error;
}

TEST(Start, IsReadByNamesOfVariablesAndEntries) {
  const StartValues start = read(R"({"good": [true, false, true], "y": 3})");
  EXPECT_EQ(start.values, (std::vector<std::int32_t>{0, 3, 1, 0, 1}));
  EXPECT_EQ(start.given, (std::vector<std::uint8_t>{0, 1, 1, 1, 1}));
  EXPECT_EQ(read(R"({"good[1]": true})").given, (std::vector<std::uint8_t>{0, 0, 0, 1, 0}));
  EXPECT_EQ(read("{}").given, std::vector<std::uint8_t>(5));
}

TEST(Start, OfWrongNamesAndValuesIsRefused) {
  EXPECT_EQ(refusal(R"({"z": 1})"), "no variable is named z; the variables are: x, y, good");
  EXPECT_EQ(refusal(R"({"good[3]": true})"), "no variable is named good[3]; the variables are: x, y, good");
  EXPECT_EQ(refusal(R"({"x": 4})"), "x: expected an integer from 0 to 3, found 4");
  EXPECT_EQ(refusal(R"({"good[0]": 2})"), "good[0]: expected true or false, found 2");
  EXPECT_EQ(refusal(R"({"good": true})"), "good: expected an array of 3, found true");
  EXPECT_EQ(refusal(R"({"good": [true, true, true], "good[0]": true})"),
            "good[0]: is given twice, as a whole and by its entries");
  EXPECT_EQ(refusal("[1]"), R"(expected a JSON object {"variable": value, ...}, found [1])");
  EXPECT_NE(refusal(std::string(100'000, '[')).find("nested deeper than"), std::string::npos);
}

State first_state(World& world, std::uint64_t run) {
  State state{};
  world.reset(run);
  world.export_state(state.data());
  return state;
}

TEST(Start, IsThatOfEachEpisodeAndLeavesTheOtherDraws) {
  std::string error;
  const auto instance = rocks().descriptor.create(ParamValues(), error);
  const auto plain = instance->make_world(7), whole = instance->make_world(7),
             partly = instance->make_world(7);
  whole->set_start(read(R"({"x": 2, "y": 1, "good": [true, false, true]})"));
  partly->set_start(read(R"({"good[1]": true})"));
  int differing = 0;
  for (std::uint64_t run = 0; run < 20; ++run) {
    EXPECT_EQ(first_state(*whole, run), (State{2, 1, 1, 0, 1}));
    State drawn = first_state(*plain, run);
    differing += drawn[3] == 0 ? 1 : 0;
    drawn[3] = 1;
    EXPECT_EQ(first_state(*partly, run), drawn);
  }
  EXPECT_GT(differing, 0);
  whole->set_start({});
  EXPECT_EQ(first_state(*whole, 3), first_state(*plain, 3));
}

TEST(Start, IsThatOfManyWorlds) {
  std::string error;
  const auto instance = rocks().descriptor.create(ParamValues(), error);
  const auto worlds = instance->make_worlds(7, 3, {});
  std::size_t refused = 3;
  EXPECT_EQ(worlds->set_start(read(R"({"x": 3})"), error), Status::kOk);
  EXPECT_EQ(worlds->reset(nullptr, nullptr, refused, error), Status::kOk);
  std::array<std::int32_t, 6> visible{};
  EXPECT_EQ(worlds->export_visible(visible.data(), error), Status::kOk);
  EXPECT_EQ(visible, (std::array<std::int32_t, 6>{3, 2, 3, 2, 3, 2}));
}

int solve(const std::string& text) {
  const std::string file = ::testing::TempDir() + "start.json";
  std::ofstream(file) << text;
  std::vector<std::string> words = {"solver", "--mode=default", "--runs=2", "--quiet", "--start", file};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  return solver_main(rocks(), static_cast<int>(arguments.size()), arguments.data());
}

TEST(Start, OfARunIsAnOption) {
  EXPECT_EQ(solve(R"({"x": 1})"), 0);
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(solve(R"({"x": 9})"), 2);
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("--start: "), std::string::npos) << said;
  EXPECT_NE(said.find("start.json: x: expected an integer from 0 to 3, found 9"), std::string::npos) << said;
}

}  // namespace
}  // namespace hypgen::testing
