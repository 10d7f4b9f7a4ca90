// SPDX-License-Identifier: Apache-2.0
// The sparse belief tree of a search and its bounds.
//
// Every value is a share of the root's value: the mean over the node's scenarios times w(b) = |Phi_b| / K *
// gamma^depth. So the values of an action's children add up. Equation and algorithm numbers are those of Ye,
// Somani, Hsu and Lee, "DESPOT: Online POMDP Planning with Regularization", JAIR 58 (2017).
//
// Several threads search one tree without a lock (docs/internals/many-threads.md):
// - Every change has an owner. A thread moves a bound by a compare-exchange. The winner adds the difference
//   to the sum of the action above. No thread adds up siblings.
// - Upper bounds fall and lower bounds rise. An upper bound rises only to a lower one that has passed it.
// - The thread that lowers a node's best action scans the node's actions for the new maximum. It scans again
//   if what it found has fallen, or if another bound has risen meanwhile.
// - The thread that first closes a leaf expands it. A thread that closes an expanded node looks once more at
//   what is below. A thread that opens a node goes up and opens the closed nodes above it.
// A single thread takes DESPOT's steps, in DESPOT's order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/memory/chunk_pool.hpp"
#include "hypgen/search/search_counts.hpp"
#include "hypgen/search/tree_data.hpp"

namespace hypgen {

struct TreeOptions {
  std::size_t memory_bytes = std::size_t{768} << 20;
  int max_depth = 90;
  double discount = 0.95;
  double pruning = 0.0;  // lambda, the regularisation constant, until `set_pruning` gives another
  std::size_t threads = 1;
  bool counts_actions = false;         // the tree counts the trials that took each action
  bool keeps_values = false;           // the tree sums their returns; not together with regularisation
  int reward_bits = math::kFixedBits;  // fraction bits of the rows' sums

  // The memory that an expansion takes in a typical tree, where an action has two groups.
  std::size_t expansion_bytes(std::size_t actions) const;
};

// The search's settings for choosing branches, in units of the root's gap.
struct BranchRatios {
  double target;       // xi
  double loss;         // c_o
  double exploration;  // c_a; 0: DESPOT's choice of actions
};

// The same settings times the root's gap eps(b0), read when a trial begins to walk.
struct BranchRule {
  double target;       // the gap of one scenario that a trial leaves alone: xi eps(b0) / K
  double loss;         // the excess uncertainty that each trial in flight hides: c_o eps(b0)
  double exploration;  // c_a eps(b0)
};

// The rule by which a trial ranks a node's actions.
struct ActionRule {
  double bonus;   // added to the upper bound; after v visits of the action, divided by sqrt(1 + v)
  double target;  // the gap of an action that a trial leaves alone: that of all scenarios of the node
};

struct ActionChoice {
  std::uint32_t place;  // kNoIndex: none
  double score;         // its upper bound and bonus at the time of the choice
};

struct ChildChoice {
  Child* child;     // null: no child with excess uncertainty is open
  bool met_closed;  // some child with excess uncertainty is closed
};

// Threads call the members at the same time, each thread with its own number. Three members need a tree that
// no thread is in: `reset`, `for_each_node` and `signature`. Only the constructor allocates.
class Tree {
 public:
  explicit Tree(const TreeOptions& options);

  // Drops all nodes and makes the root; false if there is no room. No thread may be in the tree.
  // `units`: what a scenario counts for in the rows.
  bool reset(const ChildRow& root, std::uint32_t units = 1);

  // Gives the next tree another lambda. No thread may be in the tree.
  void set_pruning(double pruning) { pruning_ = pruning; }

  // Leaves no tree. Its rows are about to go. Only while no thread is in the tree.
  void clear();

  bool is_empty() const { return root_ == nullptr; }
  Node& root() { return *root_; }
  const Node& root() const { return *root_; }

  // Adds an evaluated leaf's actions and opens the leaf for trials; false if they do not fit. Only the thread
  // that has claimed the leaf calls this. The tree keeps pointers to the rows of `result`.
  bool expand(std::size_t thread, Node& leaf, const LeafResult& result);

  // `best_action` gives an expanded node's action with the largest score. `next_action` gives the action that
  // follows `last` in falling order. Neither gives an action that cannot better the node's lower bound.
  ActionChoice best_action(const Node& node, const ActionRule& rule) const;
  ActionChoice next_action(const Node& node, const ActionRule& rule, const ActionChoice& last) const;
  ActionRule action_rule(const Node& node, const BranchRule& rule) const;

  // Gives an action's children and makes them if necessary; null if there is no room.
  ActionTable* open_action(std::size_t thread, const Node& node, std::uint32_t action);

  // Gives the open child with the largest excess uncertainty (Equation 9), less what trials in flight hide;
  // the first of equals.
  ChildChoice best_child(ActionTable& table, const BranchRule& rule) const;
  BranchRule branch_rule(const BranchRatios& ratios) const;

  // POMCP's choices. `best_value` gives the action with the largest mean value and UCB1 bonus; `exploration`
  // is UCB1's constant, and 0 gives the best mean value. `draw_child` gives the group of a scenario drawn at
  // random from `scenarios`.
  std::uint32_t best_value(const Node& node, double exploration) const;
  double mean_value(const Node& node, std::uint32_t action) const;
  Child& draw_child(ActionTable& table, std::uint32_t scenarios, std::uint32_t word) const;
  // Adds a trial's return to the actions between the root and `node`.
  void add_return(Node& node);

  // Gives the child's node and makes it if necessary; null if there is no room.
  Node* visit(std::size_t thread, Node& parent, std::uint32_t action, ActionTable& table, Child& child);

  // A trial enters each node on its way down. `backup` ends the visit. `leave` takes the visit back.
  void enter(Node& node) {
    node.child->traffic.fetch_add(Child::kVisit + 1, std::memory_order_relaxed);
    if (counts_actions_ && node.table != nullptr) node.table->visits.fetch_add(1, std::memory_order_relaxed);
  }
  void leave(Node& node) {
    node.child->traffic.fetch_sub(Child::kVisit + 1, std::memory_order_relaxed);
    if (counts_actions_ && node.table != nullptr) node.table->visits.fetch_sub(1, std::memory_order_relaxed);
  }

  // Keeps trials from a node until the node, or one below it, is expanded; false if it was closed before. The
  // thread that closes a leaf expands it, unless another has expanded it meanwhile. The thread that closes an
  // expanded node looks below once more and opens the node if something there is open.
  bool close(Node& node) { return !node.child->closed.exchange(true); }
  void open(Node& node);
  bool is_closed(const Node& node) const { return node.child->closed.load(); }

  // Whether an ancestor's default policy is as good as anything the node could add (Equation 12).
  bool is_blocked(const Node& node) const;

  // Lowers a node's upper bound to its lower bound (Algorithm 3, MAKE-DEFAULT). No trial goes on below it.
  void make_default(Node& node);

  // Ends a trial at `node` and updates the bounds from there up to the root (Equations 14 to 16).
  void backup(Node& node);

  // The lower bound of an expanded node's action: the reward and the children's lower bounds.
  double action_lower(const Node& node, std::uint32_t action) const;
  // The same when the node was expanded.
  double first_lower(const Node& node, std::uint32_t action) const {
    return row_lower(node.expanded()->rows[action], node.depth) - pruning_;
  }
  // An action's children; null if no trial has looked at the action.
  const ActionTable* table(const Expansion& expansion, std::uint32_t action) const;
  bool is_regularised() const { return pruning_ > 0.0; }
  bool counts_actions() const { return counts_actions_; }
  bool keeps_values() const { return keeps_values_; }
  double pruning() const { return pruning_; }
  // The weight of one scenario at a depth in the root's value: gamma^depth / K.
  double weight(int depth) const;
  // The number that a sum of the rows stands for.
  double number(std::int64_t sum) const { return static_cast<double>(sum) * unit_; }
  // Whether groups share scenarios. Then `count` is in units of kScenarioMass.
  bool is_weighted() const { return unit_scenarios_ != 1.0; }
  // The scenarios of a group.
  double scenarios(const Child& child) const { return child.count * unit_scenarios_; }
  // What absolute tolerances are multiplied by (`reward_scale`).
  double scale() const { return scale_; }

  // `nodes` counts the nodes that a thread has made. `crossed` counts the groups that it made with an upper
  // bound below the lower one.
  std::uint64_t nodes(std::size_t thread) const { return makers_[thread].nodes.get(); }
  std::uint64_t crossed(std::size_t thread) const { return makers_[thread].crossed.get(); }
  // Calls `visitor` with each node: thread by thread, in the order in which the thread made its nodes.
  template <class Visitor>
  void for_each_node(Visitor&& visitor) const {
    for (const Maker& maker : makers_) {
      for (const Node* node = maker.first; node != nullptr; node = node->next_made) visitor(*node);
    }
  }

  // Hashes parent, action, child index, scenarios, visits and bounds of each node, as `for_each_node` orders
  // them.
  std::uint64_t signature(std::uint64_t seed) const;

 private:
  // One thread's memory and nodes. Only that thread writes it; a cache line holds no two of them.
  struct alignas(kCacheLine) Maker {
    explicit Maker(ChunkPool& pool) : memory(pool) {}

    PoolCursor memory;
    Node* first = nullptr;
    Node* last = nullptr;
    Counter nodes;
    Counter crossed;
  };

  template <class T>
  T* get(Ref<T> ref) const {
    return ref ? &pool_[ref] : nullptr;
  }
  std::uint64_t make_child(Child* place, const ChildRow& row, int depth) const;
  Expansion* make_expansion(Maker& maker, const LeafResult& result) const;
  double set_uppers(Expansion& expansion, int depth) const;
  bool set_regularised_uppers(std::size_t thread, Node& node, Expansion& expansion, double& lower);
  double row_lower(const ActionRow& row, int depth) const;
  double explored(const Expansion& expansion, std::uint32_t action, const ActionRule& rule) const;
  ActionTable* make_table(std::size_t thread, Expansion& expansion, int depth, std::uint32_t action);
  void find_best(Expansion& expansion) const;
  void refresh(Node& node, double lower);
  void pass_on(const Node& node, double lower_change, double upper_change, double plain_change);

  ChunkPool pool_;
  std::vector<Maker> makers_;  // by thread
  Node* root_ = nullptr;
  std::vector<double> discounts_;
  double pruning_;
  double unit_;   // what 1 stands for in the rows' sums
  double scale_;  // `reward_scale` of the model
  bool counts_actions_;
  bool keeps_values_;
  double scenario_share_ = 0.0;  // 1 / K
  double unit_scenarios_ = 1.0;  // scenarios that one of a row's count stands for
};

}  // namespace hypgen
