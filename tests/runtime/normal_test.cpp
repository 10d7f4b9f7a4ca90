// SPDX-License-Identifier: Apache-2.0
#include "hypgen/math/normal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace hypgen {
namespace {

// More x than are kept, so that they take each other's places, and each twice.
TEST(RecurringNormalCdf, IsNormalCdf) {
  for (int round = 0; round < 2; ++round) {
    for (int i = -4000; i <= 4000; ++i) {
      const double x = i / 400.0;
      EXPECT_EQ(math::recurring_normal_cdf(x), math::normal_cdf(x)) << x;
      EXPECT_EQ(math::recurring_normal_cdf(x), math::normal_cdf(x)) << x;
    }
  }
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double x : {0.0, -0.0, 1e-320, infinity, -infinity}) {
    EXPECT_EQ(math::recurring_normal_cdf(x), math::normal_cdf(x)) << x;
  }
  EXPECT_TRUE(std::isnan(math::recurring_normal_cdf(std::nan(""))));
}

}  // namespace
}  // namespace hypgen
