// The sparse belief tree of a search and its bounds.
//
// All values are weighted and discounted: a node's share of the root's value, w(b) = |Phi_b| / K *
// gamma^depth times its mean, so that children add up. Equation and algorithm numbers are those of Ye,
// Somani, Hsu and Lee, "DESPOT: Online POMDP Planning with Regularization", JAIR 58 (2017).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hypgen/arena.hpp"
#include "hypgen/leaf_evaluator.hpp"

namespace hypgen {

constexpr std::uint32_t kNoIndex = UINT32_MAX;

// Bounds of a belief: `upper` and `lower` on the regularised value (mu and l), `plain_upper` without (U).
struct Bounds {
  double upper;
  double lower;
  double plain_upper;

  double gap() const { return upper - lower; }
};

// A group of scenarios below an action. Written when its parent is expanded; the bounds change in backups.
struct Child {
  Bounds bounds;
  double default_value;  // l0, weighted: what the default policy earns
  std::uint32_t first;   // the first of its scenarios: a position among the parent's
  std::uint32_t count;   // scenarios
  std::uint32_t node;    // kNoIndex until a trial first visits it
  bool terminal;
};

// An action of an expanded node.
struct ActionEntry {
  Bounds bounds;  // rho(b, a) plus the children's
  double reward;  // weighted; with the regularisation penalty it is rho(b, a)
  std::uint32_t first_child;
  std::uint32_t child_count;
  int action;
};

// A visited belief. Its bounds live in its child entry.
struct Node {
  std::uint64_t handle;        // the evaluator's, kNoHandle until expanded
  std::uint32_t parent;        // kNoIndex at the root
  std::uint32_t parent_entry;  // the action entry it is below
  std::uint32_t child;         // its own child entry
  std::uint32_t first_action;
  std::uint32_t action_count;
  std::uint32_t visits;
  int depth;

  bool expanded() const { return handle != kNoHandle; }
};

struct TreeOptions {
  std::size_t memory_bytes = std::size_t{768} << 20;
  int max_depth = 90;
  double discount = 0.95;
  double pruning = 0.0;  // lambda, the regularisation constant
};

// Allocates only when it is made.
class Tree {
 public:
  explicit Tree(const TreeOptions& options);

  // Starts a tree of one node; false if there is no room.
  bool reset(const ChildRow& root);

  // Adds an evaluated leaf's actions and children; false if they do not fit.
  bool expand(std::uint32_t node, const LeafResult& leaf);

  // The entry with the largest upper bound, the first of equals.
  std::uint32_t best_action(std::uint32_t node) const;

  // The child with the largest excess uncertainty for the target gap ratio xi (Equation 9), the first of
  // equals.
  std::uint32_t best_child(std::uint32_t action_entry, double target_ratio) const;
  double excess_uncertainty(std::uint32_t child, double target_ratio) const;

  // The child's node, made if it is not there yet; kNoIndex if there is no room.
  std::uint32_t visit(std::uint32_t node, std::uint32_t action_entry, std::uint32_t child);

  // Whether an ancestor's default policy is as good as anything the node could add (Equation 12).
  bool is_blocked(std::uint32_t node) const;

  // Makes the default policy the node's whole future (Algorithm 3, MAKE-DEFAULT). Not for the root.
  void make_default(std::uint32_t node);

  // Updates bounds from `node` up to the root (Equations 14 to 16).
  void backup(std::uint32_t node);

  const Node& node(std::uint32_t i) const { return nodes_[i]; }
  const ActionEntry& action(std::uint32_t i) const { return actions_[i]; }
  const Child& child(std::uint32_t i) const { return children_[i]; }
  const Bounds& bounds(std::uint32_t node) const { return children_[nodes_[node].child].bounds; }
  double default_value(std::uint32_t node) const { return children_[nodes_[node].child].default_value; }
  std::uint32_t size() const { return nodes_.size(); }

  // Groups whose upper bound began below what the default policy earns.
  std::uint64_t crossed() const { return crossed_; }

  // The hash of the whole tree: for each node in creation order its parent, action, child index, scenarios,
  // visits and bounds.
  std::uint64_t signature(std::uint64_t seed) const;

 private:
  Child make_child(const ChildRow& row, int depth);
  double weight(int depth) const;
  void update(ActionEntry& entry);
  void backup_node(std::uint32_t node);

  Arena<Node> nodes_;
  Arena<ActionEntry> actions_;
  Arena<Child> children_;
  std::vector<double> discounts_;
  double pruning_;
  double scenario_share_ = 0.0;  // 1 / K
  std::uint64_t crossed_ = 0;
};

}  // namespace hypgen
