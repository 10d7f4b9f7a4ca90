// SPDX-License-Identifier: Apache-2.0
// The whole command line of a generated solver.
#pragma once

#include "hypgen/model/embedded_model.hpp"

namespace hypgen {

// Runs episodes as the options say. 0: done; 1: could not run, or not write; 2: wrong options, params or start, or
// a broken model; 128 and the signal's number: interrupted; 141: nobody reads standard output.
int solver_main(const EmbeddedModel& model, int argc, char** argv);

}  // namespace hypgen
