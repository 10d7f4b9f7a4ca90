// SPDX-License-Identifier: Apache-2.0
// Bayes' rule over an enumerated model.
#include <gtest/gtest.h>

#include "exact_models.hpp"
#include "hypgen/exact/filter.hpp"

namespace hypgen::exact {
namespace {

ExactModel seen_tiger() {
  ExactModel model = make_tiger();
  model.keys = {0, 4};  // left, right
  model.variables = 1;
  model.values = {0, 1};
  return model;
}

TEST(ExactFilter, FollowsBayesRule) {
  const ExactModel model = seen_tiger();
  ExactFilter filter(model);
  ASSERT_TRUE(filter.init(nullptr));
  const std::uint64_t left = 0, right = 4;
  ASSERT_TRUE(filter.update(0, words_of(left)));
  EXPECT_DOUBLE_EQ(filter.marginal(0, 0), 0.85);
  EXPECT_DOUBLE_EQ(filter.likelihood(), 0.5);
  ASSERT_TRUE(filter.update(0, words_of(left)));
  EXPECT_DOUBLE_EQ(filter.marginal(0, 0), 0.7225 / 0.745);
  ASSERT_TRUE(filter.update(0, words_of(right)));
  EXPECT_DOUBLE_EQ(filter.belief().coeff(1), 0.15);
  ASSERT_TRUE(filter.update(1, words_of(right)));  // a door: the tiger is placed again
  EXPECT_DOUBLE_EQ(filter.belief().coeff(0), 0.5);
}

TEST(ExactFilter, KeepsTheBeliefWhereSomethingCannotHappen) {
  const ExactModel model = seen_tiger();
  ExactFilter filter(model);
  ASSERT_TRUE(filter.init(nullptr));
  const std::uint64_t left = 0, unknown = 3;
  ASSERT_TRUE(filter.update(0, words_of(left)));
  EXPECT_FALSE(filter.update(0, words_of(unknown)));
  EXPECT_DOUBLE_EQ(filter.marginal(0, 0), 0.85);
}

TEST(ExactFilter, StartsByWhatIsVisible) {
  ExactModel model = seen_tiger();
  model.starts[0].visible = {7};
  ExactFilter filter(model);
  const std::int32_t seven = 7, eight = 8;
  EXPECT_TRUE(filter.init(&seven));
  EXPECT_FALSE(filter.init(&eight));
}

TEST(ExactFilter, MeasuresTheDistanceOfBeliefs) {
  SparseBelief a(4), b(4);
  a.insert(0) = 0.5;
  a.insert(2) = 0.5;
  b.insert(2) = 0.25;
  b.insert(3) = 0.75;
  EXPECT_DOUBLE_EQ(total_variation(a, b), 0.75);
  EXPECT_DOUBLE_EQ(total_variation(a, a), 0.0);
}

}  // namespace
}  // namespace hypgen::exact
