#include "hypgen/tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hypgen/model.hpp"
#include "hypgen/scan.hpp"
#include "hypgen/signature.hpp"

namespace hypgen {

namespace {

constexpr double kRounding = 1e-6;

// How the budget is shared out; what fills first ends the growth of the tree.
constexpr double kNodeShare = 0.1, kActionShare = 0.4, kChildShare = 0.5;

std::size_t entries(std::size_t bytes, double share, std::size_t size) {
  return static_cast<std::size_t>(static_cast<double>(bytes) * share) / size + 1;
}

std::size_t action_bytes(bool regularised) {
  return sizeof(ActionEntry) + (regularised ? 2 : 1) * sizeof(double);
}

}  // namespace

Tree::Tree(const TreeOptions& options)
    : nodes_(entries(options.memory_bytes, kNodeShare, sizeof(Node))),
      actions_(entries(options.memory_bytes, kActionShare, action_bytes(options.pruning > 0.0))),
      uppers_(actions_.capacity()),
      plain_uppers_(options.pruning > 0.0 ? actions_.capacity() : 0),
      children_(entries(options.memory_bytes, kChildShare, sizeof(Child))),
      pruning_(options.pruning) {
  double power = 1.0;
  for (int depth = 0; depth <= options.max_depth; ++depth, power *= options.discount) {
    discounts_.push_back(power);
  }
}

double Tree::weight(int depth) const { return discounts_[static_cast<std::size_t>(depth)] * scenario_share_; }

bool Tree::reset(const ChildRow& root) {
  nodes_.reset();
  actions_.reset();
  children_.reset();
  crossed_ = 0;
  scenario_share_ = 1.0 / root.count;
  children_[children_.allocate(1)] = make_child(root, 0);
  return visit(kNoIndex, kNoIndex, 0) != kNoIndex;
}

Child Tree::make_child(const ChildRow& row, int depth) {
  const double share = weight(depth);
  Child child{};
  child.first = row.first;
  child.count = row.count;
  child.node = kNoIndex;
  child.default_value = share * from_fixed_sum(row.lower_sum);
  double upper = share * from_fixed_sum(row.upper_sum);
  if (upper < child.default_value) {
    // Bounds that are equal but for rounding have not crossed.
    if (child.default_value - upper > kRounding * (share * row.count + std::abs(upper))) ++crossed_;
    upper = child.default_value;
  }
  // A subtree costs lambda at least, or is the default policy.
  child.bounds = {std::max(child.default_value, upper - pruning_), child.default_value, upper};
  return child;
}

bool Tree::fits(const LeafResult& leaf) const {
  return actions_.fits(leaf.actions.size()) && (!is_regularised() || children_.fits(leaf.children.size()));
}

bool Tree::expand(std::uint32_t node_index, const LeafResult& leaf) {
  if (!fits(leaf)) return false;
  Node& node = nodes_[node_index];
  node.handle = leaf.handle;
  node.rows = leaf.children.begin();
  node.action_count = static_cast<std::uint32_t>(leaf.actions.size());
  node.first_action = actions_.allocate(leaf.actions.size());
  const double lower =
      is_regularised() ? add_regularised(node, leaf.actions) : add_actions(node, leaf.actions);
  seek_best(node);
  refresh(node_index, lower);
  reopen(node_index);
  return true;
}

// Fills in a node's actions from the rows' sums; gives the largest lower bound.
double Tree::add_actions(const Node& node, Span<const ActionRow> rows) {
  const double reward_share = weight(node.depth), share = weight(node.depth + 1);
  ActionEntry* const entries = &actions_[node.first_action];
  double* const uppers = &uppers_[node.first_action];
  double best = -std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < rows.size(); ++a) {
    const ActionRow& row = rows[a];
    const double reward = reward_share * from_fixed_sum(row.reward_sum);
    const double lower = reward + share * from_fixed_sum(row.lower_sum);
    uppers[a] = reward + share * from_fixed_sum(row.upper_sum);
    entries[a] = {lower, row.action, row.first_child, row.child_count & INT32_MAX, 0};
    best = std::max(best, lower);
  }
  return best;
}

// The same with regularisation, where each child has a penalty of its own.
double Tree::add_regularised(const Node& node, Span<const ActionRow> rows) {
  double best = -std::numeric_limits<double>::infinity();
  for (std::uint32_t a = 0; a < node.action_count; ++a) {
    const ActionRow& row = rows[a];
    const std::uint32_t place = node.first_action + a;
    ActionEntry& entry = actions_[place];
    entry = {0.0, row.action, row.first_child, row.child_count & INT32_MAX, 0};
    make_children(node, entry);
    const double reward = weight(node.depth) * from_fixed_sum(row.reward_sum);
    Bounds sum{reward - pruning_, reward - pruning_, reward};
    for (std::uint32_t i = 0; i < entry.child_count; ++i) {
      const Bounds& child = children_[entry.first + i].bounds;
      sum.upper += child.upper;
      sum.lower += child.lower;
      sum.plain_upper += child.plain_upper;
    }
    uppers_[place] = sum.upper;
    entry.lower = sum.lower;
    plain_uppers_[place] = sum.plain_upper;
    best = std::max(best, sum.lower);
  }
  return best;
}

void Tree::make_children(const Node& node, ActionEntry& entry) {
  const ChildRow* rows = node.rows + entry.first;
  entry.first = children_.allocate(entry.child_count);
  entry.opened = 1;
  for (std::uint32_t i = 0; i < entry.child_count; ++i) {
    children_[entry.first + i] = make_child(rows[i], node.depth + 1);
  }
}

bool Tree::open(std::uint32_t node_index, std::uint32_t entry_index) {
  ActionEntry& entry = actions_[entry_index];
  if (entry.opened != 0) return true;
  if (!children_.fits(entry.child_count)) return false;
  make_children(nodes_[node_index], entry);
  return true;
}

void Tree::seek_best(Node& node) const {
  if (node.action_count == 0) return;
  const std::size_t best = first_largest(&uppers_[node.first_action], node.action_count);
  node.best = node.first_action + static_cast<std::uint32_t>(best);
}

std::uint32_t Tree::next_action(std::uint32_t node_index, std::uint32_t entry) const {
  const Node& node = nodes_[node_index];
  const double* uppers = &uppers_[node.first_action];
  const std::uint32_t last = entry - node.first_action;
  double best = bounds(node_index).lower;
  std::uint32_t found = kNoIndex;
  for (std::uint32_t i = 0; i < node.action_count; ++i) {
    const bool comes_after = uppers[i] < uppers[last] || (uppers[i] == uppers[last] && i > last);
    if (comes_after && uppers[i] > best) {
      best = uppers[i];
      found = node.first_action + i;
    }
  }
  return found;
}

double Tree::excess_uncertainty(std::uint32_t child_index, double target_ratio) const {
  const Child& child = children_[child_index];
  return child.bounds.gap() - child.count * (scenario_share_ * target_ratio * bounds(0).gap());
}

ChildChoice Tree::best_child(std::uint32_t entry_index, const ChildRule& rule) const {
  const ActionEntry& entry = actions_[entry_index];
  const double target = scenario_share_ * rule.target_ratio * bounds(0).gap();
  const double loss = rule.observation_loss * bounds(0).gap();
  ChildChoice choice{kNoIndex, false};
  double best = -std::numeric_limits<double>::infinity();
  for (std::uint32_t i = entry.first; i < entry.first + entry.child_count; ++i) {
    const Child& child = children_[i];
    const double excess = child.bounds.gap() - child.count * target;
    if (!(excess > 0.0)) continue;
    choice.met_closed |= child.closed;
    const double left = excess - loss * child.in_flight;
    if (!child.closed && left > best) {
      best = left;
      choice.child = i;
    }
  }
  return choice;
}

std::uint32_t Tree::visit(std::uint32_t parent, std::uint32_t entry, std::uint32_t child_index) {
  Child& child = children_[child_index];
  if (child.node == kNoIndex) {
    const std::uint32_t made = nodes_.allocate(1);
    if (made == Arena<Node>::kFull) return kNoIndex;
    Node& node = nodes_[made];
    node = {};
    node.handle = kNoHandle;
    node.parent = parent;
    node.parent_entry = entry;
    node.child = child_index;
    node.best = kNoIndex;
    node.depth = parent == kNoIndex ? 0 : nodes_[parent].depth + 1;
    child.node = made;
  }
  return child.node;
}

void Tree::enter(std::uint32_t node) {
  ++nodes_[node].visits;
  ++children_[nodes_[node].child].in_flight;
}

void Tree::leave(std::uint32_t node) {
  --nodes_[node].visits;
  --children_[nodes_[node].child].in_flight;
}

bool Tree::is_blocked(std::uint32_t node_index) const {
  double penalty = 0.0;
  for (std::uint32_t i = nodes_[node_index].parent; i != kNoIndex; i = nodes_[i].parent) {
    penalty += pruning_;
    if (bounds(i).plain_upper - default_value(i) <= penalty) return true;
  }
  return false;
}

void Tree::make_default(std::uint32_t node) {
  const double lower = bounds(node).lower;
  set_bounds(node, {lower, lower, lower});
}

// Gives a node its bounds and adds what has changed to its parent's action.
void Tree::set_bounds(std::uint32_t node_index, const Bounds& bounds) {
  const Node& node = nodes_[node_index];
  Child& child = children_[node.child];
  const Bounds before = child.bounds;
  child.bounds = bounds;
  if (node.parent == kNoIndex) return;
  Node& parent = nodes_[node.parent];
  const std::uint32_t entry = node.parent_entry;
  actions_[entry].lower += bounds.lower - before.lower;
  if (is_regularised()) plain_uppers_[entry] += bounds.plain_upper - before.plain_upper;
  if (bounds.upper == before.upper) return;
  uppers_[entry] += bounds.upper - before.upper;
  // An upper bound rises only where the lower one has crossed it.
  if (parent.best == entry || bounds.upper > before.upper) seek_best(parent);
}

// Takes over an expanded node's bounds from its actions, one of which reaches `lower`.
void Tree::refresh(std::uint32_t node_index, double lower) {
  const Node& node = nodes_[node_index];
  if (!node.expanded()) return;
  Bounds bounds = children_[node.child].bounds;
  bounds.lower = std::max(bounds.lower, lower);
  double upper = bounds.lower, plain_upper = bounds.lower;
  if (node.action_count > 0) {
    upper = uppers_[node.best];
    plain_upper = is_regularised() ? largest(&plain_uppers_[node.first_action], node.action_count) : upper;
  }
  // What an upper bound has once excluded stays so, even where the model's bounds of successors are looser.
  bounds.upper = std::max(bounds.lower, std::min(bounds.upper, upper));
  bounds.plain_upper = std::max(bounds.lower, std::min(bounds.plain_upper, plain_upper));
  set_bounds(node_index, bounds);
}

// A node is closed above one that is in expansion only if the latter closed its parent.
void Tree::reopen(std::uint32_t node) {
  children_[nodes_[node].child].closed = false;
  for (std::uint32_t i = nodes_[node].parent; i != kNoIndex && is_closed(i); i = nodes_[i].parent) {
    children_[nodes_[i].child].closed = false;
  }
}

void Tree::backup(std::uint32_t node_index) {
  while (true) {
    const Node& node = nodes_[node_index];
    --children_[node.child].in_flight;
    if (node.parent == kNoIndex) return;
    refresh(node.parent, actions_[node.parent_entry].lower);
    node_index = node.parent;
  }
}

Bounds Tree::action_bounds(std::uint32_t entry) const {
  return {uppers_[entry], actions_[entry].lower, is_regularised() ? plain_uppers_[entry] : uppers_[entry]};
}

std::uint64_t Tree::signature(std::uint64_t seed) const {
  Signature hash(seed);
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    const Child& child = children_[node.child];
    hash.add(std::uint64_t{node.parent});
    if (node.parent != kNoIndex) {
      const ActionEntry& entry = actions_[node.parent_entry];
      hash.add(static_cast<std::uint64_t>(entry.action));
      hash.add(std::uint64_t{node.child - entry.first});
    }
    hash.add(std::uint64_t{child.count});
    hash.add(std::uint64_t{node.visits});
    hash.add(child.bounds.upper);
    hash.add(child.bounds.lower);
  }
  return hash.value();
}

}  // namespace hypgen
