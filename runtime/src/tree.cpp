#include "hypgen/tree.hpp"

#include <algorithm>
#include <cmath>

#include "hypgen/model.hpp"
#include "hypgen/signature.hpp"

namespace hypgen {

namespace {

// How the budget is shared out; what fills first ends the growth of the tree.
constexpr double kRounding = 1e-6;

constexpr double kNodeShare = 0.1, kActionShare = 0.4, kChildShare = 0.5;

std::size_t entries(std::size_t bytes, double share, std::size_t size) {
  return static_cast<std::size_t>(static_cast<double>(bytes) * share) / size + 1;
}

}  // namespace

Tree::Tree(const TreeOptions& options)
    : nodes_(entries(options.memory_bytes, kNodeShare, sizeof(Node))),
      actions_(entries(options.memory_bytes, kActionShare, sizeof(ActionEntry))),
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
  const std::uint32_t child = children_.allocate(1);
  const std::uint32_t node = nodes_.allocate(1);
  if (child == Arena<Child>::kFull || node == Arena<Node>::kFull) return false;
  children_[child] = make_child(root, 0);
  children_[child].node = node;
  nodes_[node] = {kNoHandle, kNoIndex, kNoIndex, child, 0, 0, 0, 0};
  return true;
}

Child Tree::make_child(const ChildRow& row, int depth) {
  const double share = weight(depth);
  Child child{};
  child.first = row.first;
  child.count = row.count;
  child.node = kNoIndex;
  child.terminal = row.terminal;
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

bool Tree::expand(std::uint32_t node_index, const LeafResult& leaf) {
  if (!actions_.fits(leaf.actions.size()) || !children_.fits(leaf.children.size())) return false;
  Node& node = nodes_[node_index];
  const std::uint32_t first_child = children_.allocate(leaf.children.size());
  for (std::size_t i = 0; i < leaf.children.size(); ++i) {
    children_[first_child + i] = make_child(leaf.children[i], node.depth + 1);
  }
  node.handle = leaf.handle;
  node.first_action = actions_.allocate(leaf.actions.size());
  node.action_count = static_cast<std::uint32_t>(leaf.actions.size());
  for (std::uint32_t a = 0; a < node.action_count; ++a) {
    const ActionRow& row = leaf.actions[a];
    ActionEntry& entry = actions_[node.first_action + a];
    entry.reward = weight(node.depth) * from_fixed_sum(row.reward_sum);
    entry.first_child = first_child + row.first_child;
    entry.child_count = row.child_count;
    entry.action = row.action;
    update(entry);
  }
  return true;
}

void Tree::update(ActionEntry& entry) {
  Bounds sum{entry.reward - pruning_, entry.reward - pruning_, entry.reward};
  for (std::uint32_t i = 0; i < entry.child_count; ++i) {
    const Bounds& child = children_[entry.first_child + i].bounds;
    sum.upper += child.upper;
    sum.lower += child.lower;
    sum.plain_upper += child.plain_upper;
  }
  entry.bounds = sum;
}

std::uint32_t Tree::best_action(std::uint32_t node_index) const {
  const Node& node = nodes_[node_index];
  std::uint32_t best = node.first_action;
  for (std::uint32_t i = 1; i < node.action_count; ++i) {
    if (actions_[node.first_action + i].bounds.upper > actions_[best].bounds.upper)
      best = node.first_action + i;
  }
  return best;
}

double Tree::excess_uncertainty(std::uint32_t child_index, double target_ratio) const {
  const Child& child = children_[child_index];
  return child.bounds.gap() - child.count * scenario_share_ * target_ratio * bounds(0).gap();
}

std::uint32_t Tree::best_child(std::uint32_t action_entry, double target_ratio) const {
  const ActionEntry& entry = actions_[action_entry];
  const double target = scenario_share_ * target_ratio * bounds(0).gap();
  std::uint32_t best = entry.first_child;
  double best_excess = -1e300;
  for (std::uint32_t i = 0; i < entry.child_count; ++i) {
    const Child& child = children_[entry.first_child + i];
    const double excess = child.bounds.gap() - child.count * target;
    if (excess > best_excess) {
      best = entry.first_child + i;
      best_excess = excess;
    }
  }
  return best;
}

std::uint32_t Tree::visit(std::uint32_t node_index, std::uint32_t action_entry, std::uint32_t child_index) {
  Child& child = children_[child_index];
  if (child.node == kNoIndex) {
    const std::uint32_t made = nodes_.allocate(1);
    if (made == Arena<Node>::kFull) return kNoIndex;
    nodes_[made] = {kNoHandle, node_index, action_entry, child_index, 0, 0, 0, nodes_[node_index].depth + 1};
    child.node = made;
  }
  return child.node;
}

bool Tree::is_blocked(std::uint32_t node_index) const {
  double penalty = 0.0;
  for (std::uint32_t i = nodes_[node_index].parent; i != kNoIndex; i = nodes_[i].parent) {
    penalty += pruning_;
    if (bounds(i).plain_upper - default_value(i) <= penalty) return true;
  }
  return false;
}

void Tree::make_default(std::uint32_t node_index) {
  Node& node = nodes_[node_index];
  Child& child = children_[node.child];
  child.bounds = {child.default_value, child.default_value, child.default_value};
  ++node.visits;
  update(actions_[node.parent_entry]);
}

void Tree::backup_node(std::uint32_t node_index) {
  const Node& node = nodes_[node_index];
  if (!node.expanded()) return;
  Child& child = children_[node.child];
  Bounds best{child.default_value, child.default_value, child.default_value};
  for (std::uint32_t i = 0; i < node.action_count; ++i) {
    const Bounds& action = actions_[node.first_action + i].bounds;
    best.upper = std::max(best.upper, action.upper);
    best.lower = std::max(best.lower, action.lower);
    best.plain_upper = std::max(best.plain_upper, action.plain_upper);
  }
  // What an upper bound has once excluded stays so, even where the model's bounds of successors are looser.
  child.bounds.upper = std::max(best.lower, std::min(child.bounds.upper, best.upper));
  child.bounds.plain_upper = std::max(best.lower, std::min(child.bounds.plain_upper, best.plain_upper));
  child.bounds.lower = best.lower;
}

void Tree::backup(std::uint32_t node_index) {
  while (true) {
    backup_node(node_index);
    Node& node = nodes_[node_index];
    ++node.visits;
    if (node.parent == kNoIndex) return;
    update(actions_[node.parent_entry]);
    node_index = node.parent;
  }
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
      hash.add(std::uint64_t{node.child - entry.first_child});
    }
    hash.add(std::uint64_t{child.count});
    hash.add(std::uint64_t{node.visits});
    hash.add(child.bounds.upper);
    hash.add(child.bounds.lower);
  }
  return hash.value();
}

}  // namespace hypgen
