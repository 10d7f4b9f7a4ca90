// SPDX-License-Identifier: Apache-2.0
#include "hypgen/search/tree_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace hypgen {

namespace {

// Sums drift by rounding with each change that is added to them; of the root's initial bounds.
constexpr double kDrift = 1e-9;

class TreeCheck {
 public:
  TreeCheck(const Tree& tree, bool may_be_closed)
      : tree_(tree),
        may_be_closed_(may_be_closed),
        tolerance_(kDrift * (tree.scale() + scale(*tree.root().child))) {}

  std::string run() {
    tree_.for_each_node([&](const Node& node) {
      if (!fault_.empty()) return;
      const char* const wrong = check(node);
      if (wrong == nullptr) return;
      char place[80];
      std::snprintf(place, sizeof place, "node %u at depth %d: ", node.number, node.depth);
      fault_ = std::string(place) + wrong;
    });
    return fault_;
  }

 private:
  static double scale(const Child& root) {
    return std::max(std::abs(root.default_value), std::abs(root.upper.load()));
  }

  const char* check(const Node& node) const {
    const Child& child = *node.child;
    if (child.node.load() != &node) return "its child names another node";
    if (child.in_flight() != 0) return "a trial is in flight";
    if (child.closed.load() && !may_be_closed_) return "it is closed";
    if (child.upper.load() < child.lower.load()) return "the bounds crossed";
    if (child.lower.load() < child.default_value) return "the lower bound fell";
    const Expansion* const expansion = node.expanded();
    return expansion == nullptr ? nullptr : check_expanded(node, *expansion);
  }

  const char* check_expanded(const Node& node, const Expansion& expansion) const {
    const Child& child = *node.child;
    std::uint64_t visits_below = 0;
    double largest = child.lower.load();
    for (std::uint32_t a = 0; a < expansion.action_count; ++a) {
      const double upper = expansion.uppers()[a].load();
      largest = a == 0 ? upper : std::max(largest, upper);
      if (tree_.action_lower(node, a) > child.lower.load()) return "an action has a larger lower bound";
      if (tree_.keeps_values() && !std::isfinite(tree_.mean_value(node, a))) return "a value is not finite";
      const ActionTable* const table = tree_.table(expansion, a);
      if (table == nullptr) continue;
      const char* const wrong = check_table(node, expansion, a, *table);
      if (wrong != nullptr) return wrong;
      for (const Child& below : *table) visits_below += below.visits();
    }
    if (expansion.action_count > 0) {
      if (expansion.largest.load() != largest) return "another upper bound is the largest";
      if (expansion.uppers()[expansion.best.load()].load() != largest) return "another action is the best";
    }
    if (child.upper.load() > std::max(child.lower.load(), largest))
      return "its upper bound is above its actions'";
    if (child.visits() < visits_below) return "more trials went on than came";
    return nullptr;
  }

  const char* check_table(const Node& node, const Expansion& expansion, std::uint32_t action,
                          const ActionTable& table) const {
    const ActionRow& row = expansion.rows[action];
    const double reward = tree_.weight(node.depth) * tree_.number(row.reward_sum) - tree_.pruning();
    double upper = expansion.uppers()[action].load() - reward, lower = table.lower.load() - reward;
    std::uint32_t count = 0;
    std::uint64_t visits = 0;
    for (std::uint32_t i = 0; i < table.count; ++i) {
      const Child& child = table.children()[i];
      upper -= child.upper.load();
      lower -= child.lower.load();
      count += child.count;
      visits += child.visits();
      const ChildRow& group = expansion.child_rows[row.first_child + i];
      const double first_upper = tree_.weight(node.depth + 1) * tree_.number(group.upper_sum);
      if (child.upper.load() > std::max(child.lower.load(), first_upper)) return "a child's upper bound rose";
    }
    if (!(std::abs(upper) <= tolerance_)) return "an action's upper bound is not the sum of its children's";
    if (!(std::abs(lower) <= tolerance_)) return "an action's lower bound is not the sum of its children's";
    if (tree_.counts_actions() && table.visits.load() != visits)
      return "an action's visits are not its children's";
    if (count != node.child->count) return "an action's children are not the node's scenarios";
    return nullptr;
  }

  const Tree& tree_;
  bool may_be_closed_;
  double tolerance_;
  std::string fault_;
};

}  // namespace

std::string tree_fault(const Tree& tree, bool may_be_closed) {
  return tree.is_empty() ? "" : TreeCheck(tree, may_be_closed).run();
}

}  // namespace hypgen
