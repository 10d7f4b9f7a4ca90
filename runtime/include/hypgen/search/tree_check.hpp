// What has to hold of a search tree once no thread is in it: for tests.
#pragma once

#include <string>

#include "hypgen/search/tree.hpp"

namespace hypgen {

// Says what is wrong, of the first node where something is; empty: nothing is. Leaves in expansion may have
// been abandoned if `may_be_closed`; otherwise every node has to be open.
std::string tree_fault(const Tree& tree, bool may_be_closed);

}  // namespace hypgen
