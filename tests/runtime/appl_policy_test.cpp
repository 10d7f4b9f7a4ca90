// SPDX-License-Identifier: Apache-2.0
// Policies in APPL's format: there and back, those of other programs, and files that are no such thing.
#include "hypgen/exact/appl_policy.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <sstream>
#include <string>

#include "exact_models.hpp"
#include "hypgen/exact/interval.hpp"

namespace hypgen::exact {
namespace {

AlphaPolicy solve(const ExactModel& model) {
  IntervalOptions options;
  options.seconds = 20.0;
  options.gap = 1e-6;
  return solve_interval(model, options, [](const IntervalResult&) { return true; }).alpha;
}

ExactDescriptor tiger_descriptor() {
  ExactDescriptor descriptor;
  descriptor.descriptor.name = "Tiger--1";
  descriptor.descriptor.file = "tiger & \"co\".pomdp";
  descriptor.descriptor.action_names = {"listen", "open--left", "open(right)"};
  descriptor.value_names = [](const std::int32_t*) { return std::vector<std::string>{"<left>"}; };
  return descriptor;
}

std::string written(const ExactModel& model, const AlphaPolicy& policy) {
  std::ostringstream out;
  write_appl_policy(out, tiger_descriptor(), model, policy);
  return out.str();
}

AlphaPolicy read(const std::string& text, const ExactModel& model) {
  std::istringstream in(text);
  return read_appl_policy(in, tiger_descriptor(), model);
}

std::string problem_of(const std::string& text, const ExactModel& model) {
  try {
    read(text, model);
  } catch (const PolicyError& error) {
    return error.what();
  }
  return "";
}

std::string without_names(const std::string& text) {
  const std::size_t begin = text.find("<!--"), end = text.find("-->");
  return text.substr(0, begin) + text.substr(end + 3);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  EXPECT_NE(text.find(from), std::string::npos);
  return text.replace(text.find(from), from.size(), to);
}

TEST(ApplPolicy, ComesBackEqual) {
  for (const ExactModel& model : {make_tiger(), make_tiger_with_horizon(4)}) {
    const AlphaPolicy policy = solve(model);
    const AlphaPolicy back = read(written(model, policy), model);
    ASSERT_EQ(back.classes().size(), policy.classes().size());
    for (std::size_t c = 0; c < policy.classes().size(); ++c) {
      const auto& ours = policy.classes()[c].vectors;
      const auto& theirs = back.classes()[c].vectors;
      ASSERT_EQ(theirs.size(), ours.size());
      for (std::size_t i = 0; i < ours.size(); ++i) {
        EXPECT_EQ(theirs[i].action, ours[i].action);
        EXPECT_EQ(theirs[i].values, ours[i].values);
      }
    }
  }
}

TEST(ApplPolicy, SaysTheSameWithoutOurNames) {
  const ExactModel model = make_tiger_with_horizon(4);
  const AlphaPolicy policy = solve(model);
  const AlphaPolicy back = read(without_names(written(model, policy)), model);
  for (int t = 0; t < 4; ++t) {
    for (const double left : {0.0, 0.1, 0.5, 0.97}) {
      SparseBelief belief(model.states);
      belief.coeffRef(2 * t) = left;
      belief.coeffRef(2 * t + 1) = 1.0 - left;
      EXPECT_EQ(back.action(belief), policy.action(belief));
      EXPECT_EQ(back.value(belief), policy.value(belief));
    }
  }
}

TEST(ApplPolicy, IsWrittenAsXmlOverTheExportedStates) {
  const ExactModel model = make_tiger_with_horizon(4);
  const std::string text = written(model, solve(model));
  EXPECT_NE(text.find("vectorLength=\"9\" numObsValue=\"1\""), std::string::npos);  // the last: it has ended
  EXPECT_NE(text.find("model=\"tiger &amp; &quot;co&quot;.pomdp\""), std::string::npos);
  const std::size_t comment = text.find("<!-- ") + 4, end = text.find(" -->");
  EXPECT_EQ(text.substr(comment, end - comment).find("--"), std::string::npos);
}

TEST(ApplPolicy, HasTheStatesThatAreSplit) {
  // What is seen on coming to state 1 depends on whether one was there.
  ExactModel model;
  model.discount = 0.9;
  model.observations = 2;
  set_classes(model, {0, 2});
  model.starts = {make_start(2, 1.0, {0})};
  model.actions = {make_action({1.0, 0.0}, {{{0, 1, 0.3}, {1, 1, 0.7}}, {{0, 1, 0.6}, {1, 1, 0.4}}})};
  const std::string text = written(model, solve(model));
  EXPECT_NE(text.find("vectorLength=\"3\""), std::string::npos);
  EXPECT_EQ(problem_of(text, model), "");
}

TEST(ApplPolicy, RefusesWhatIsNotAPolicyOfTheModel) {
  const ExactModel model = make_tiger();
  const std::string text = written(model, solve(model)), bare = without_names(text);
  ExactModel other = make_tiger();
  other.actions[0].reward[0] = -2.0;
  EXPECT_NE(problem_of(text, other).find("of another model, or of other params"), std::string::npos);
  EXPECT_EQ(problem_of(bare, other), "");  // nothing tells
  EXPECT_NE(problem_of(bare, make_tiger_with_horizon(4)).find("has 9 states"), std::string::npos);
  EXPECT_NE(problem_of(replaced(text, "\"listen\"", "\"hear\""), model).find("action 0 of the policy"),
            std::string::npos);
  EXPECT_NE(problem_of(text.substr(0, text.size() - 30), model), "");
  EXPECT_NE(problem_of(text.substr(0, text.size() / 2), model), "");
  EXPECT_NE(problem_of("<", model), "");
  EXPECT_NE(problem_of("<html></html>", model), "");
  EXPECT_NE(
      problem_of(replaced(text, "numObsValue=\"1\"", "numObsValue=\"4\""), model).find("fully observed"),
      std::string::npos);
  EXPECT_NE(problem_of(replaced(bare, "<Vector action=\"0\"", "<Vector action=\"7\""), model), "");
  EXPECT_NE(problem_of(replaced(bare, "</Vector>", "nan </Vector>"), model), "");
  EXPECT_NE(problem_of(replaced(bare, "</Vector>", "1.0 </Vector>"), model), "");
  EXPECT_NE(problem_of(replaced(bare, "numVectors=\"", "numVectors=\"1"), model), "");
  EXPECT_NE(problem_of(replaced(bare, "vectorLength=\"2\"", "vectorLength=\"-2\""), model), "");
  EXPECT_NE(problem_of(replaced(bare, "<Vector ", "<SparseVector "), model), "");
}

TEST(ApplPolicy, RefusesWhatIsHostile) {
  const ExactModel model = make_tiger();
  const std::string text = written(model, solve(model));
  EXPECT_NE(problem_of("<" + std::string(17'000'000, 'x'), model).find("larger than 16 MB"),
            std::string::npos);
  EXPECT_NE(problem_of("<!-- hypgen " + std::string(100000, '['), model), "");
  EXPECT_NE(problem_of("<!-- hypgen " + std::string(100000, '[') + "--><Policy>", model), "");
  EXPECT_NE(problem_of("<!-- hypgen -->" + text, model), "");
  const std::size_t names = text.find("\"actions\":[");
  ASSERT_NE(names, std::string::npos);
  const std::size_t end = text.find(']', names);
  EXPECT_NE(problem_of(text.substr(0, names) + "\"actions\":{\"a\":1" + "}" + text.substr(end + 1), model),
            "");
}

TEST(ApplPolicy, IsRefusedWhereItIsTooLarge) {
  const ExactModel model = make_tiger();
  EXPECT_EQ(appl_policy_problem(model, solve(model)), "");
  ExactModel large;
  large.states = static_cast<int>(kMostPolicyNumbers);
  EXPECT_NE(appl_policy_problem(large, solve(model)).find("too many for APPL's format"), std::string::npos);
}

}  // namespace
}  // namespace hypgen::exact
