// SPDX-License-Identifier: Apache-2.0
// The invariants of a search tree that no thread is in, for tests.
#pragma once

#include <string>

#include "hypgen/search/tree.hpp"

namespace hypgen {

// Describes the first fault of the first faulty node; empty if there is none. With `may_be_closed` nodes may
// be closed, as a search that stops abandons leaves in expansion. Without, every node has to be open.
std::string tree_fault(const Tree& tree, bool may_be_closed);

}  // namespace hypgen
