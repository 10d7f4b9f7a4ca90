// SPDX-License-Identifier: Apache-2.0
// What stands behind the `hypgen_model` of hypgen.h: the generated unit of a library defines one.
#pragma once

#include <hypgen.h>

#include "hypgen/core/status.hpp"
#include "hypgen/model/embedded_model.hpp"

// What tells two versions of the runtime apart, as an identifier. A build sets it for the sources that name
// this_runtime: c_worlds.cpp and a model's library.cpp.
#ifndef HYPGEN_RUNTIME_ID
#define HYPGEN_RUNTIME_ID runtime_of_no_build
#endif

namespace hypgen {

// A status as hypgen.h has it.
hypgen_status code_of(Status status);

// Has another address in each shared library, as it is not exported: tells the models of one from those of others.
// The version is part of its name, so that no program links a model with another version than its own.
inline namespace HYPGEN_RUNTIME_ID {
void this_runtime();
}

}  // namespace hypgen

struct hypgen_model {
  void (*runtime)();
  hypgen::EmbeddedModel (*make)();
};
