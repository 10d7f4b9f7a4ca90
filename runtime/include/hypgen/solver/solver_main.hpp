// SPDX-License-Identifier: Apache-2.0
// The whole command line of a generated solver.
#pragma once

#include "hypgen/model/embedded_model.hpp"

namespace hypgen {

// Runs episodes as the options say. 0: done; 1: could not run; 2: wrong options, params or start.
int solver_main(const EmbeddedModel& model, int argc, char** argv);

}  // namespace hypgen
