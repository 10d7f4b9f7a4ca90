// SPDX-License-Identifier: Apache-2.0
// The exact solver's program.
#pragma once

#include "hypgen/exact/exact_instance.hpp"

namespace hypgen::exact {

// Enumerates the model and does what the command line says. Returns the exit code: 0, 1 where the model is
// too large or a file cannot be written, 2 for wrong use, 128 and the signal's number after an interrupt (what
// is proven so far is printed first).
int exact_main(const ExactDescriptor& model, int argc, char** argv);

}  // namespace hypgen::exact
