// SPDX-License-Identifier: Apache-2.0
#include "hypgen/model/params.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>

namespace hypgen {
namespace {

const std::vector<ParamSpec> kSpecs = {
    {"hearing", ParamKind::kProb, 0.0, 1.0, {}, {0.5}, {}},
    {"rocks", ParamKind::kInt, 0.0, 6.0, {2, 3}, {}, {}},
    {"wind", ParamKind::kEnum, 0.0, 1.0, {}, {0.0}, {"calm", "storm"}},
    {"wet", ParamKind::kBool, 0.0, 1.0, {2}, {0.0, 0.0}, {}},
    {"map",
     ParamKind::kEnum,
     0.0,
     2.0,
     {2, 3},
     {0, 0, 0, 0, 0, 0},
     {"floor", "wall", "lift"},
     {{".", 0}, {"#", 1}, {"\u2195", 2}}},
};

std::string error_of(const std::string& text) {
  ParamValues values(kSpecs);
  std::string error;
  EXPECT_FALSE(read_params(text, kSpecs, values, error));
  return error;
}

TEST(Params, ReadsEveryKind) {
  ParamValues values(kSpecs);
  std::string error;
  ASSERT_TRUE(read_params(
      R"({"hearing": 0.25, "rocks": [[1, 2, 3], [4, 5, 6]], "wind": "storm", "wet": [true, false]})", kSpecs,
      values, error))
      << error;
  float hearing = 0;
  std::int32_t rocks[6], wind[1];
  bool wet[2];
  ASSERT_TRUE(values.copy("hearing", &hearing, 1, error));
  ASSERT_TRUE(values.copy("rocks", rocks, 6, error));
  ASSERT_TRUE(values.copy("wind", wind, 1, error));
  ASSERT_TRUE(values.copy("wet", wet, 2, error));
  EXPECT_EQ(hearing, 0.25F);
  EXPECT_EQ(rocks[5], 6);
  EXPECT_EQ(wind[0], 1);
  EXPECT_TRUE(wet[0]);
  EXPECT_TRUE(check_complete(kSpecs, values, error));
}

TEST(Params, AcceptsFlatArrays) {
  ParamValues values(kSpecs);
  std::string error;
  EXPECT_TRUE(read_params(R"({"rocks": [1, 2, 3, 4, 5, 6]})", kSpecs, values, error)) << error;
}

TEST(Params, ReadsGridsOfGlyphs) {
  for (const char* text :
       {R"({"map": ["..#", "#\u2195."]})", R"({"map": [["floor", ".", "wall"], "#\u2195."]})",
        R"({"map": [".", ".", "#", "#", "lift", "."]})"}) {
    ParamValues values(kSpecs);
    std::string error;
    std::int32_t map[6];
    ASSERT_TRUE(read_params(text, kSpecs, values, error)) << error;
    ASSERT_TRUE(values.copy("map", map, 6, error));
    EXPECT_EQ(map[2], 1);
    EXPECT_EQ(map[4], 2);
    EXPECT_EQ(map[5], 0);
  }
  EXPECT_EQ(error_of(R"({"map": ["..#", "#x."]})"),
            "param \"map\": 'x' is no glyph of it (character 2 of \"#x.\"); they are '#' '.' '\u2195'");
  EXPECT_EQ(error_of(R"({"map": ["..#", "#."]})"),
            "param \"map\": expected a string of 3 glyphs, found 2 in \"#.\"");
}

TEST(Params, NamesWhatIsWrong) {
  EXPECT_NE(error_of("{\"hearing\": }").find("not valid JSON"), std::string::npos);
  EXPECT_EQ(error_of("{\"hearing\": -1e400}").find("not valid JSON: number overflow"), 0U);
  EXPECT_EQ(error_of("nope").find("not valid JSON: parse error at line 1, column 2"), 0U);
  EXPECT_EQ(error_of(" \n").find("is empty; expected a JSON object"), 0U);
  EXPECT_NE(error_of("[]").find("expected a JSON object"), std::string::npos);
  EXPECT_EQ(error_of(R"({"rock": 1})"),
            "unknown param \"rock\"; the model's params are hearing, rocks, wind, wet, map");
  EXPECT_EQ(error_of(R"({"hearing": 1.5})"),
            "param \"hearing\": expected probability from 0 to 1, found 1.5");
  EXPECT_EQ(error_of(R"({"rocks": [1, 2]})"),
            "param \"rocks\": expected an array of 2 x 3 values (integer from 0 to 6), found [1,2]");
  EXPECT_EQ(error_of(R"({"rocks": [1, 2, 3, 4, 5, 7]})"),
            "param \"rocks\": expected integer from 0 to 6, found 7");
  EXPECT_EQ(error_of(R"({"rocks": [1, 2, 3, 4, 5, 0.5]})"),
            "param \"rocks\": expected integer from 0 to 6, found 0.5");
  EXPECT_EQ(error_of(R"({"wind": "breeze"})"),
            "param \"wind\": expected one of \"calm\", \"storm\", found \"breeze\"");
  EXPECT_EQ(error_of(R"({"wet": [1, 0]})"), "param \"wet\": expected bool (true or false), found 1");
  EXPECT_EQ(error_of(R"({"hearing": [0.5]})"),
            "param \"hearing\": expected a single value (probability from 0 to 1), found [0.5]");
}

TEST(Params, MissesValuesWithoutDefault) {
  std::string error;
  EXPECT_FALSE(check_complete(kSpecs, ParamValues(kSpecs), error));
  EXPECT_NE(error.find("\"rocks\" has no value"), std::string::npos);
  EXPECT_NE(error.find("2 x 3"), std::string::npos);
}

TEST(Params, RefusesJsonThatIsHostile) {
  const std::string deep(100000, '['), deep_objects = "{\"rocks\":" + std::string(100000, '[');
  EXPECT_EQ(error_of(deep), "has values nested deeper than 100 levels");
  EXPECT_EQ(error_of(deep_objects), "has values nested deeper than 100 levels");
  EXPECT_EQ(error_of(R"({"hearing": 0.1, "hearing": 0.2})"), "\"hearing\" is given twice in one object");
  EXPECT_EQ(error_of(R"({"wet": {"a": 1, "a": 2}})"), "\"a\" is given twice in one object");
  EXPECT_EQ(error_of(R"({"hearing": NaN})").find("not valid JSON"), 0U);
  EXPECT_EQ(error_of("{\"hearing\": Infinity}").find("not valid JSON"), 0U);
  EXPECT_EQ(error_of("{\"h\xff\": 1}").find("not valid JSON"), 0U);
  EXPECT_EQ(error_of("{\"h\xff\": 1}").find('\xff'), std::string::npos);  // messages are UTF-8
  EXPECT_EQ(error_of(R"({"hearing": 99999999999999999999999999})"),
            "param \"hearing\": expected probability from 0 to 1, found 1e+26");
  EXPECT_EQ(error_of(R"({"rocks": [1, 2, 3, 4, 5, 18446744073709551615]})"),
            "param \"rocks\": expected integer from 0 to 6, found 18446744073709551615");
  EXPECT_EQ(error_of("{\"" + std::string(100000, 'a') + "\": 1}").size(),
            error_of("{\"" + std::string(60, 'a') + "\": 1}").size() + 3);
}

// What a message shows of a text is short, on one line, and UTF-8.
TEST(Params, ShowsWhatWasFoundHarmlessly) {
  const std::string shown = error_of(R"({"wind": "\u001b[2J\u0085\r\nx"})");
  EXPECT_EQ(std::count_if(shown.begin(), shown.end(), [](char c) { return '\0' <= c && c < ' '; }), 0);
  const std::string cut = error_of("{\"wind\": \"" + std::string(58, 'a') + "\u2195\u2195\"}");
  EXPECT_NE(cut.find(std::string(58, 'a') + "..."), std::string::npos) << cut;
}

std::string problem_of_file(const std::string& file) {
  ParamValues values(kSpecs);
  std::string error;
  EXPECT_FALSE(read_param_file(file, kSpecs, values, error));
  return error;
}

TEST(Params, NamesAFileThatCannotBeRead) {
  EXPECT_EQ(problem_of_file("/nonexistent/params.json"),
            "/nonexistent/params.json: cannot be read: No such file or directory");
  EXPECT_EQ(problem_of_file("/"), "/: cannot be read: Is a directory");
}

TEST(Params, RefusesFilesThatAreNoText) {
  EXPECT_EQ(problem_of_file("/dev/zero"), "/dev/zero: is a binary file, not a text");
  EXPECT_EQ(problem_of_file("/dev/null").find("/dev/null: is empty"), 0U);
  const std::string large = testing::TempDir() + "params_large";
  std::ofstream(large) << std::string(16'000'001, ' ');
  EXPECT_EQ(problem_of_file(large), large + ": is larger than 16 MB");
  std::remove(large.c_str());
}

TEST(Params, ReadsAPipeThatSomebodyWritesInto) {
  const std::string pipe = testing::TempDir() + "params_written";
  std::remove(pipe.c_str());
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(pipe) << R"({"hearing": 0.25})"; });
  ParamValues values(kSpecs);
  std::string error;
  EXPECT_TRUE(read_param_file(pipe, kSpecs, values, error)) << error;
  writer.join();
  std::remove(pipe.c_str());
}

}  // namespace
}  // namespace hypgen
