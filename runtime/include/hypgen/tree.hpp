// The sparse belief tree of a search and its bounds.
//
// All values are weighted and discounted: a node's share of the root's value, w(b) = |Phi_b| / K *
// gamma^depth times its mean, so that children add up. Equation and algorithm numbers are those of Ye,
// Somani, Hsu and Lee, "DESPOT: Online POMDP Planning with Regularization", JAIR 58 (2017).
//
// Upper bounds only fall and lower bounds only rise, exactly (but where the model's cross): what changes
// below is added to the sums above as a difference of one sign. So a node's best action is sought only where
// that action's bound fell, and its lower bound is a maximum of two numbers.
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

// A group of scenarios below an action. Made when a trial first looks at the action; the bounds change in
// backups, the rest as trials pass.
struct Child {
  Bounds bounds;
  double default_value;     // l0, weighted: what the default policy earns
  std::uint32_t first;      // the first of its scenarios: a position among the parent's
  std::uint32_t count;      // scenarios
  std::uint32_t node;       // kNoIndex until a trial first visits it
  std::uint16_t in_flight;  // trials that have gone down to it or below, and are not backed up
  bool closed;              // in expansion, or everything that a trial could take below it is
};

// An action of an expanded node. Its upper bounds stand in arrays of their own.
struct ActionEntry {
  double lower;
  int action;
  std::uint32_t first;  // its first group: among the node's rows, or of its children once they are made
  std::uint32_t child_count : 31;
  std::uint32_t opened : 1;  // its children are made
};

// A visited belief. Its bounds live in its child entry.
struct Node {
  std::uint64_t handle;        // the evaluator's, kNoHandle until expanded
  const ChildRow* rows;        // of its actions' groups, the evaluator's
  std::uint32_t parent;        // kNoIndex at the root
  std::uint32_t parent_entry;  // the action entry it is below
  std::uint32_t child;         // its own child entry
  std::uint32_t first_action;
  std::uint32_t action_count;
  std::uint32_t best;  // the entry with the largest upper bound, the first of equals; kNoIndex: none
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

// How a trial chooses among an action's children.
struct ChildRule {
  double target_ratio;  // xi
  double
      observation_loss;  // c_o: what a trial in flight takes from the excess uncertainty, of the root's gap
};

struct ChildChoice {
  std::uint32_t child;  // kNoIndex: none with excess uncertainty is open
  bool met_closed;      // one with excess uncertainty is closed
};

// Allocates only when it is made.
class Tree {
 public:
  explicit Tree(const TreeOptions& options);

  // Starts a tree of one node; false if there is no room.
  bool reset(const ChildRow& root);

  // Adds an evaluated leaf's actions and opens the leaf for trials; false if they do not fit. The leaf's
  // child rows have to stay.
  bool expand(std::uint32_t node, const LeafResult& leaf);

  // The action that comes after `entry` in falling order of upper bounds, if it can be better than what the
  // node has; otherwise kNoIndex.
  std::uint32_t next_action(std::uint32_t node, std::uint32_t entry) const;

  // Makes the children of an action if they are not there yet; false if there is no room.
  bool open(std::uint32_t node, std::uint32_t entry);

  // Of an opened action's children with excess uncertainty (Equation 9) the one where it is largest, less
  // what trials in flight take; the first of equals.
  ChildChoice best_child(std::uint32_t entry, const ChildRule& rule) const;
  double excess_uncertainty(std::uint32_t child, double target_ratio) const;

  // The child's node, made if it is not there yet; kNoIndex if there is no room.
  std::uint32_t visit(std::uint32_t node, std::uint32_t entry, std::uint32_t child);

  // A trial goes down to a node; it ends with `backup`, or with `leave` as if it had not come.
  void enter(std::uint32_t node);
  void leave(std::uint32_t node);

  // No trial enters the node until it, or a node below it, is expanded.
  void close(std::uint32_t node) { children_[nodes_[node].child].closed = true; }
  bool is_closed(std::uint32_t node) const { return children_[nodes_[node].child].closed; }

  // Whether an ancestor's default policy is as good as anything the node could add (Equation 12).
  bool is_blocked(std::uint32_t node) const;

  // Makes what the node has its whole future (Algorithm 3, MAKE-DEFAULT): the default policy, if it is not
  // expanded.
  void make_default(std::uint32_t node);

  // Ends a trial at `node`: updates bounds from there up to the root (Equations 14 to 16).
  void backup(std::uint32_t node);

  const Node& node(std::uint32_t i) const { return nodes_[i]; }
  const ActionEntry& action(std::uint32_t i) const { return actions_[i]; }
  const Child& child(std::uint32_t i) const { return children_[i]; }
  const Bounds& bounds(std::uint32_t node) const { return children_[nodes_[node].child].bounds; }
  double default_value(std::uint32_t node) const { return children_[nodes_[node].child].default_value; }
  Bounds action_bounds(std::uint32_t entry) const;
  std::uint32_t size() const { return nodes_.size(); }

  // Groups, of those that trials looked at, whose upper bound began below what the default policy earns.
  std::uint64_t crossed() const { return crossed_; }

  // The hash of the whole tree: for each node in creation order its parent, action, child index, scenarios,
  // visits and bounds.
  std::uint64_t signature(std::uint64_t seed) const;

 private:
  bool fits(const LeafResult& leaf) const;
  Child make_child(const ChildRow& row, int depth);
  double weight(int depth) const;
  bool is_regularised() const { return pruning_ > 0.0; }
  void make_children(const Node& node, ActionEntry& entry);
  double add_actions(const Node& node, Span<const ActionRow> rows);
  double add_regularised(const Node& node, Span<const ActionRow> rows);
  void seek_best(Node& node) const;
  void refresh(std::uint32_t node, double lower);
  void set_bounds(std::uint32_t node, const Bounds& bounds);
  void reopen(std::uint32_t node);

  Arena<Node> nodes_;
  Arena<ActionEntry> actions_;
  Arena<double> uppers_;        // of actions_, at the same places
  Arena<double> plain_uppers_;  // likewise; only with regularisation
  Arena<Child> children_;
  std::vector<double> discounts_;
  double pruning_;
  double scenario_share_ = 0.0;  // 1 / K
  std::uint64_t crossed_ = 0;
};

}  // namespace hypgen
