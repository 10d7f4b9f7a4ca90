// SPDX-License-Identifier: Apache-2.0
// A search tree as JSON text, for people and programs that ask why.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "hypgen/leaves/scenario_walk.hpp"
#include "hypgen/model/embedded_model.hpp"
#include "hypgen/model/key_codec.hpp"
#include "hypgen/search/tree.hpp"

namespace hypgen {

// How much of a tree to tell.
struct TreeExtent {
  int depth = 2;             // levels of actions
  std::size_t most = 10;     // actions of a node, by trials, and groups of an action, by scenarios
  std::size_t nodes = 5000;  // beliefs and actions in all, those that most trials took

  static constexpr int kMostDepth = 100;  // the text is written by recursion
};

// The text, and how many beliefs and actions it has.
struct TreeText {
  std::string json;
  std::size_t shown = 0;
};

// The beliefs and actions of a whole tree.
std::size_t tree_size(const Tree& tree);

// `tree` is the last search's, at rest, and not empty; `walk` is at its root. Bounds and values are those of the
// node itself. Lambda counts as in the root's value: divided by the node's discount and share of all scenarios.
TreeText tree_text(const EmbeddedModel& model, const KeyCodec& codec, const Tree& tree, ScenarioWalk& walk,
                   const TreeExtent& extent);

}  // namespace hypgen
