// SPDX-License-Identifier: Apache-2.0
#include "hypgen/model/params.hpp"

#include <gtest/gtest.h>

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

TEST(Params, NamesAFileThatCannotBeRead) {
  ParamValues values(kSpecs);
  std::string error;
  EXPECT_FALSE(read_param_file("/nonexistent/params.json", kSpecs, values, error));
  EXPECT_EQ(error, "/nonexistent/params.json: cannot be read");
  EXPECT_FALSE(read_param_file("/", kSpecs, values, error));
  EXPECT_EQ(error, "/: cannot be read");
}

}  // namespace
}  // namespace hypgen
