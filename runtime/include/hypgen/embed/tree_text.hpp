// SPDX-License-Identifier: Apache-2.0
// A search tree as JSON text, for people and programs that ask why.
#pragma once

#include <cstddef>
#include <string>

#include "hypgen/embed/key_codec.hpp"
#include "hypgen/leaves/scenario_walk.hpp"
#include "hypgen/model/embedded_model.hpp"
#include "hypgen/search/tree.hpp"

namespace hypgen {

// How much of a tree to tell.
struct TreeExtent {
  int depth = 2;          // levels of actions
  std::size_t most = 10;  // actions of a node, by trials, and groups of an action, by scenarios

  static constexpr int kMostDepth = 100;  // the text is written by recursion
};

// `tree` is the last search's, at rest, and not empty; `walk` is at its root. Bounds and values are those of the
// node itself. Lambda counts as in the root's value: divided by the node's discount and share of all scenarios.
std::string tree_text(const EmbeddedModel& model, const KeyCodec& codec, const Tree& tree, ScenarioWalk& walk,
                      const TreeExtent& extent);

}  // namespace hypgen
