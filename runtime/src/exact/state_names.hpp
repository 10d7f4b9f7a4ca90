// SPDX-License-Identifier: Apache-2.0
// States with the names of the model.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hypgen/exact/exact_instance.hpp"
#include "hypgen/exact/exact_model.hpp"

namespace hypgen::exact {

// All values of a state.
std::vector<std::string> values_of(const ExactDescriptor& descriptor, const ExactModel& model, int state);

// A state in which an episode may start so.
int first_state(const ExactModel& model, std::size_t start);
std::vector<int> states_of_starts(const ExactModel& model);

// What tells some states apart to the eye: the visible variables in which they differ.
class SeenNames {
 public:
  SeenNames(const ExactDescriptor& descriptor, const ExactModel& model, const std::vector<int>& states);

  // "robot.cell=3, robot.seen=true"; empty where all look alike.
  std::string of(int state) const;

 private:
  static constexpr std::size_t kMostVariables = 8;

  const ExactDescriptor& descriptor_;
  const ExactModel& model_;
  std::vector<std::size_t> variables_;
  bool has_more_ = false;
};

}  // namespace hypgen::exact
