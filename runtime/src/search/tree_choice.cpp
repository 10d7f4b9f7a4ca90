// SPDX-License-Identifier: Apache-2.0
// The choice of the branch by which a trial goes on from a node.
#include <algorithm>
#include <cmath>
#include <limits>

#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/search/tree.hpp"

namespace hypgen {

BranchRule Tree::branch_rule(const BranchRatios& ratios) const {
  // The gap may be below 0 between the moves of two threads.
  const double gap = std::max(0.0, root_->child->gap());
  return {scenario_share_ * ratios.target * gap, ratios.loss * gap, ratios.exploration * gap};
}

// The bonus is c_a eps(b0) w(b) sqrt(log(n N(b)) / (n N(b, a))), with n = max(|Phi_b|, 2). It is weighted as
// upper bounds are: without a weight it alone would decide wherever few scenarios are left. Counts start at
// 1, and N(b) includes the trial that asks.
ActionRule Tree::action_rule(const Node& node, const BranchRule& rule) const {
  const Child& child = *node.child;
  if (rule.exploration == 0.0) return {0.0, 0.0};
  const double count = scenarios(child), scenarios = std::max(count, 2.0);
  const double visits = static_cast<double>(child.visits());
  // The logarithm of models, which has the same bits with every library.
  const double logarithm = math::log(static_cast<float>(scenarios * visits));
  const double bonus = rule.exploration * weight(node.depth) * count * std::sqrt(logarithm / scenarios);
  return {bonus, count * rule.target};
}

// Without exploration the tree knows the best action. With exploration, an action counts only if its gap
// exceeds the gap that a trial leaves alone; below any other a trial would end at once. The action with the
// largest upper bound always counts.
ActionChoice Tree::best_action(const Node& node, const ActionRule& rule) const {
  const Expansion& expansion = *node.expanded();
  const std::uint32_t best = expansion.best.load();
  if (best == kNoIndex) return {kNoIndex, 0.0};
  if (rule.bonus == 0.0) return {best, expansion.uppers()[best].load()};
  return next_action(node, rule, {0, std::numeric_limits<double>::infinity()});
}

// The order rests on the score that `last` had when it was chosen. Bounds that fall meanwhile cannot send a
// trial in circles.
ActionChoice Tree::next_action(const Node& node, const ActionRule& rule, const ActionChoice& last) const {
  const Expansion& expansion = *node.expanded();
  const double lower = node.child->lower.load();
  ActionChoice found{kNoIndex, -std::numeric_limits<double>::infinity()};
  for (std::uint32_t i = 0; i < expansion.action_count; ++i) {
    const double upper = expansion.uppers()[i].load();
    // This dismisses most actions: visits only lessen the bonus.
    if (!(upper > lower && upper + rule.bonus > found.score)) continue;
    const double score = upper + explored(expansion, i, rule);
    const bool comes_after = score < last.score || (score == last.score && i > last.place);
    if (!comes_after || !(score > found.score)) continue;
    if (rule.bonus > 0.0 && !(upper - action_lower(node, i) > rule.target)) continue;
    found = {i, score};
  }
  return found;
}

// The bonus that exploration adds to an action's upper bound.
double Tree::explored(const Expansion& expansion, std::uint32_t action, const ActionRule& rule) const {
  const ActionTable* const opened = rule.bonus > 0.0 ? table(expansion, action) : nullptr;
  if (opened == nullptr) return rule.bonus;
  return rule.bonus / std::sqrt(1.0 + opened->visits.load(std::memory_order_relaxed));
}

ChildChoice Tree::best_child(ActionTable& table, const BranchRule& rule) const {
  ChildChoice choice{nullptr, false};
  double best = -std::numeric_limits<double>::infinity();
  for (Child& child : table) {
    const double excess = child.gap() - scenarios(child) * rule.target;
    if (!(excess > 0.0)) continue;
    const bool closed = child.closed.load();
    choice.met_closed |= closed;
    const double left = excess - rule.loss * static_cast<double>(child.in_flight());
    if (!closed && left > best) {
      best = left;
      choice.child = &child;
    }
  }
  return choice;
}

}  // namespace hypgen
