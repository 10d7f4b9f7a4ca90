// SPDX-License-Identifier: Apache-2.0
// From the steps of a model to its matrices.
#include "hypgen/exact/enumeration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace hypgen::exact {
namespace {

// A place of 0 .. 2, which is seen, and a coin that is not. Action 0 walks on and shows the coin, rightly
// with probability 3/4, as 7 or 5; from place 2 it ends the episode. Action 1, at place 0 only, stays and
// tosses the coin. The start is at place 0, or with probability 1/2 at place 1.
class Path final : public OutcomeModel {
 public:
  int actions() const override { return 2; }
  int variables() const override { return 2; }
  int visible() const override { return 1; }
  int state_words() const override { return 1; }
  int key_words() const override { return 1; }

  bool start(std::size_t, Outcomes& out) const override {
    out.clear();
    for (const std::uint32_t coin : {0U, 1U, 1U, 0U}) add(0.125, 0, coin, 0, out);
    for (const std::uint32_t coin : {0U, 1U}) add(0.25, 1, coin, 0, out);
    return true;
  }

  bool step(const std::uint32_t* state, int action, std::size_t most, Outcomes& out) const override {
    out.clear();
    const std::uint32_t place = state[0] / 2, coin = state[0] % 2;
    out.reward = place + 0.5;
    out.error = has_error;
    if (most < 4) return false;
    if (action == 1) {
      for (const std::uint32_t side : {0U, 1U, 1U}) add(side == 0 ? 0.5 : 0.25, place, side, 0, out);
    } else if (place < 2) {
      add(0.75, place + 1, coin, coin == 1 ? 7 : 5, out);
      add(0.25, place + 1, coin, coin == 1 ? 5 : 7, out);
    }
    return true;
  }

  bool is_legal(const std::uint32_t* state, int action) const override { return action == 0 || state[0] < 2; }
  void export_visible(const std::uint32_t* state, std::int32_t* out) const override {
    out[0] = static_cast<std::int32_t>(state[0] / 2);
  }
  void export_state(const std::uint32_t* state, std::int32_t* out) const override {
    out[0] = static_cast<std::int32_t>(state[0] / 2);
    out[1] = static_cast<std::int32_t>(state[0] % 2);
  }

  bool has_error = false;

 private:
  static void add(double p, std::uint32_t place, std::uint32_t coin, std::uint64_t key, Outcomes& out) {
    out.probabilities.push_back(p);
    out.states.push_back(2 * place + coin);
    out.keys.push_back(key);
  }
};

Enumeration enumerate_path(int horizon, const EnumerationLimits& limits = {}) {
  return enumerate(Path(), 0.9, horizon, limits, [](const EnumerationCounts&) { return true; });
}

TEST(Enumeration, FindsStatesByClassAndMergesEqualOutcomes) {
  const Enumeration result = enumerate_path(0);
  ASSERT_EQ(result.problem, "");
  const ExactModel& model = result.model;
  EXPECT_EQ(model.states, 6);
  EXPECT_EQ(model.seen, (std::vector<int>{0, 0, 1, 1, 2, 2}));
  EXPECT_EQ(model.class_begin, (std::vector<int>{0, 2, 4, 6}));
  EXPECT_EQ(model.classes(), 3);
  EXPECT_EQ(model.values, (std::vector<std::int32_t>{0, 0, 0, 1, 1, 0, 1, 1, 2, 0, 2, 1}));
  EXPECT_EQ(model.keys, (std::vector<std::uint64_t>{0, 5, 7}));

  const ExactAction& walk = model.actions[0];
  EXPECT_EQ(walk.observations, (std::vector<int>{1, 2}));
  EXPECT_EQ(walk.begin, (std::vector<int>{0, 4, 8}));
  EXPECT_EQ(walk.next, (std::vector<int>{2, 3, 4, 5, 2, 3, 4, 5}));
  EXPECT_EQ(walk.outcomes.coeff(0, 0), 0.75);  // the coin of state 0 is shown as 5
  EXPECT_EQ(walk.outcomes.coeff(1, 5), 0.75);
  EXPECT_EQ(walk.outcomes.row(4).sum(), 0.0);  // which ends the episode
  EXPECT_EQ(walk.reward[4], 2.5);

  const ExactAction& toss = model.actions[1];
  EXPECT_EQ(toss.outcomes.nonZeros(), 4);
  EXPECT_EQ(toss.outcomes.coeff(0, 1), 0.5);
  EXPECT_TRUE(std::isinf(toss.reward[2]));
  EXPECT_EQ(toss.outcomes.row(2).sum(), 0.0);
}

TEST(Enumeration, StartsOncePerClass) {
  const ExactModel model = enumerate_path(0).model;
  ASSERT_EQ(model.starts.size(), 2U);
  EXPECT_EQ(model.starts[0].probability, 0.5);
  EXPECT_EQ(model.starts[1].visible, (std::vector<std::int32_t>{1}));
  EXPECT_EQ(model.starts[1].belief.nonZeros(), 2);
  EXPECT_EQ(model.starts[1].belief.coeff(2), 0.5);
}

TEST(Enumeration, MakesTimePartOfTheStateWhereThereIsAHorizon) {
  const ExactModel model = enumerate_path(2).model;
  EXPECT_EQ(model.states, 10);  // places 0 and 1 at the start; 0, 1 and 2 a step later
  EXPECT_EQ(model.classes(), 5);
  for (int state = 0; state < model.states; ++state) {
    const bool is_last = model.steps[static_cast<std::size_t>(state)] == 1;
    EXPECT_EQ(model.actions[0].outcomes.row(state).nonZeros(), is_last ? 0 : 2);
    for (SparseMatrix::InnerIterator entry(model.actions[0].outcomes, state); entry; ++entry) {
      EXPECT_EQ(
          model.steps[static_cast<std::size_t>(model.actions[0].next[static_cast<std::size_t>(entry.col())])],
          1);
    }
  }
}

TEST(Enumeration, SaysWhatIsTooMuch) {
  EnumerationLimits limits;
  limits.states = 3;
  EXPECT_NE(enumerate_path(0, limits).problem.find("more than 3 states (4 states found, 1"),
            std::string::npos);
  limits = {};
  limits.outcomes = 5;
  EXPECT_NE(enumerate_path(0, limits).problem.find("raise --max-outcomes"), std::string::npos);
  limits = {};
  limits.bytes = 1;
  EXPECT_NE(enumerate_path(0, limits).problem.find("--memory"), std::string::npos);
  Path wrong;
  wrong.has_error = true;
  const auto go_on = [](const EnumerationCounts&) { return true; };
  EXPECT_NE(enumerate(wrong, 0.9, 0, {}, go_on).problem.find("not a number"), std::string::npos);
  EXPECT_TRUE(enumerate(Path(), 0.9, 0, {}, [](const EnumerationCounts&) { return false; }).stopped);
}

}  // namespace
}  // namespace hypgen::exact
