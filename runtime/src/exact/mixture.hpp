// SPDX-License-Identifier: Apache-2.0
// A belief as the cheapest mixture of points and corners: a linear program with a row for each of its states.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "hypgen/exact/refinement.hpp"

namespace hypgen::exact {

// The beliefs of a class's points as columns, and what each of them costs.
struct PricedPoints {
  Eigen::MatrixXd beliefs;
  Eigen::VectorXd costs;
};

// Makes the mixture cheaper by the simplex method, from what it is; from corners alone where that is no mixture
// of the belief. `corners` has the cost of each of the belief's states. The points give no state more than an
// epsilon above what the belief has.
Mixture cheapest_mixture(const PricedPoints& points, const ClassBelief& belief,
                         const std::vector<double>& corners, Mixture mixture);

}  // namespace hypgen::exact
