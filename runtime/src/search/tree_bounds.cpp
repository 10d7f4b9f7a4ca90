// SPDX-License-Identifier: Apache-2.0
// The movement of a search tree's bounds: a thread moves a node's own bounds, then those above it.
#include <limits>

#include "hypgen/search/atomic_maximum.hpp"
#include "hypgen/search/monotone.hpp"
#include "hypgen/search/tree.hpp"

namespace hypgen {

// Sets `best` and `largest` by scans, until one scan stands. Four events void a scan:
// - The bound that it found has fallen since. The thread that lowered it may have read the old `best`, and
//   then does not scan itself.
// - Another thread has changed `largest` since the scan began.
// - A bound has risen since the scan began. `largest` does not show it if it was changed and changed back.
// - The scan itself has raised `largest`. The bound that it found may have fallen before the store, seen by a
//   thread that found the old `largest` right.
void Tree::find_best(Expansion& expansion) const {
  if (expansion.action_count == 0) return;
  while (true) {
    const std::uint32_t rises = expansion.rises.load();
    double before = expansion.largest.load();
    const Largest found = largest(expansion.uppers(), expansion.action_count);
    expansion.best.store(found.place);
    if (expansion.uppers()[found.place].load() < found.value) continue;
    if (!expansion.largest.compare_exchange_strong(before, found.value)) continue;
    if (found.value <= before && expansion.rises.load() == rises) return;
  }
}

// Moves an expanded node's bounds to those of its actions. `lower` is a lower bound of one of them.
void Tree::refresh(Node& node, double lower) {
  const Expansion* const expansion = node.expanded();
  if (expansion == nullptr) return;
  Child& child = *node.child;
  const double lower_change = raise_to(child.lower, lower);
  // The upper bound never rises to that of its actions: the model's bounds of successors may be looser.
  const double upper_change = lower_to(child.upper, child.lower, expansion->largest.load());
  double plain_change = 0.0;
  if (is_regularised()) {
    const double plain_upper = expansion->action_count == 0
                                   ? -std::numeric_limits<double>::infinity()
                                   : largest(expansion->plain_uppers(), expansion->action_count).value;
    plain_change = lower_to(child.plain_upper, child.lower, plain_upper);
  }
  pass_on(node, lower_change, upper_change, plain_change);
}

void Tree::make_default(Node& node) {
  constexpr double kAsLowAsPossible = -std::numeric_limits<double>::infinity();
  Child& child = *node.child;
  const double upper_change = lower_to(child.upper, child.lower, kAsLowAsPossible);
  const double plain_change =
      is_regularised() ? lower_to(child.plain_upper, child.lower, kAsLowAsPossible) : 0.0;
  pass_on(node, 0.0, upper_change, plain_change);
}

// Adds the changes that this thread has made to a node's bounds to the parent's action.
void Tree::pass_on(const Node& node, double lower_change, double upper_change, double plain_change) {
  if (node.parent == nullptr) return;
  Expansion& above = *node.parent->expanded();
  if (lower_change != 0.0) add(node.table->lower, lower_change);
  if (plain_change != 0.0) add(above.plain_uppers()[node.action], plain_change);
  if (upper_change == 0.0) return;
  add(above.uppers()[node.action], upper_change);
  // An upper bound rises only where a lower bound has crossed it.
  if (upper_change > 0.0) above.rises.fetch_add(1);
  if (upper_change > 0.0 || above.best.load() == node.action) find_best(above);
}

void Tree::backup(Node& from) {
  Node* node = &from;
  while (true) {
    node->child->traffic.fetch_sub(1, std::memory_order_relaxed);
    if (node->parent == nullptr) return;
    const double lower = node->table->lower.load();
    node = node->parent;
    refresh(*node, lower);
  }
}

// The nodes above are opened too: one that was closed for a moment may have made a trial close its parent.
void Tree::open(Node& node) {
  node.child->closed.store(false);
  for (Node* above = node.parent; above != nullptr && is_closed(*above); above = above->parent) {
    above->child->closed.store(false);
  }
}

bool Tree::is_blocked(const Node& node) const {
  double penalty = 0.0;
  for (const Node* above = node.parent; above != nullptr; above = above->parent) {
    penalty += pruning_;
    if (above->child->plain_upper.load() - above->child->default_value <= penalty) return true;
  }
  return false;
}

}  // namespace hypgen
