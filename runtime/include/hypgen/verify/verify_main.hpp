// SPDX-License-Identifier: Apache-2.0
// The program that checks a model's code.
#pragma once

#include "hypgen/verify/verifiable_model.hpp"

namespace hypgen {

// Does the check that the command line asks for. 0: nothing found; 1: something differs or is violated, or the
// check could not run; 2: wrong options or params; 128 and a signal's number: interrupted.
int verify_main(const VerifiableModel& model, int argc, char** argv);

}  // namespace hypgen
