// SPDX-License-Identifier: Apache-2.0
// A test model as a library has it.
#pragma once

#include <cstdint>
#include <string>

#include "hypgen/model/embedded_model.hpp"
#include "test_solvers.hpp"

namespace hypgen::testing {

inline EmbeddedModel rocks() {
  EmbeddedModel model{rock_sample_descriptor<4, 3>()};
  model.descriptor.hidden_variables = {{"good", 2, 3, false}};
  model.visible = {{"x", {}, ValueKind::kInt, 0, 3}, {"y", {}, ValueKind::kInt, 0, 3}};
  model.hidden = {{"good", {3}, ValueKind::kBool, 0, 1}};
  model.seen = {{"reading", {}, ValueKind::kNamed, 0, 2, [](std::int32_t value) {
                   return std::string(value == 0 ? "nothing" : value == 1 ? "looks_good" : "looks_bad");
                 }}};
  return model;
}

}  // namespace hypgen::testing
