// SPDX-License-Identifier: Apache-2.0
// The whole command line of a generated program.
#pragma once

#include "hypgen/model/embedded_model.hpp"

namespace hypgen {

// Serves an agent on standard input and output if the options say --serve, and is `solver_main` otherwise. Ends as
// that does.
int program_main(EmbeddedModel model, int argc, char** argv);

}  // namespace hypgen
