// The sparse belief tree of a search and its bounds.
//
// All values are weighted and discounted: a node's share of the root's value, w(b) = |Phi_b| / K *
// gamma^depth times its mean, so that children add up. Equation and algorithm numbers are those of Ye,
// Somani, Hsu and Lee, "DESPOT: Online POMDP Planning with Regularization", JAIR 58 (2017).
//
// Several threads search one tree without a lock (docs/design/0004-many-threads.md):
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
#include "hypgen/memory/chunk_pool.hpp"
#include "hypgen/search/search_counts.hpp"
#include "hypgen/search/tree_data.hpp"

namespace hypgen {

struct TreeOptions {
  std::size_t memory_bytes = std::size_t{768} << 20;
  int max_depth = 90;
  double discount = 0.95;
  double pruning = 0.0;  // lambda, the regularisation constant
  std::size_t threads = 1;
  bool counts_actions = false;  // how often each was taken
  bool keeps_values = false;    // what trials that took it have earned. Not with regularisation
};

// How trials choose, in units of the root's gap.
struct BranchRatios {
  double target;       // xi
  double loss;         // c_o
  double exploration;  // c_a; 0: DESPOT's choice of actions
};

// The same as the root's gap was when a trial began to walk.
struct BranchRule {
  double target;       // the gap that is left alone, of a scenario: xi eps(b0) / K
  double loss;         // what a trial in flight takes from the excess uncertainty: c_o eps(b0)
  double exploration;  // c_a eps(b0)
};

// How a node's actions are ranked.
struct ActionRule {
  double bonus;   // of an action that no trial has taken; with v visits it is divided by sqrt(1 + v)
  double target;  // what an action leaves alone of its gap: that of all scenarios of the node
};

struct ActionChoice {
  std::uint32_t place;  // kNoIndex: none
  double score;         // its upper bound when it was chosen, with what exploring adds
};

struct ChildChoice {
  Child* child;     // null: none with excess uncertainty is open
  bool met_closed;  // one with excess uncertainty is closed
};

// Members that are not const are called by many threads at once, each with its own number, but for `reset`.
// `for_each_node` and `signature` too need a tree that no thread is in.
// Allocates only when it is made.
class Tree {
 public:
  explicit Tree(const TreeOptions& options);

  // Starts a tree of one node; false if there is no room. Only while no thread is in the tree.
  bool reset(const ChildRow& root);

  bool is_empty() const { return root_ == nullptr; }
  Node& root() { return *root_; }
  const Node& root() const { return *root_; }

  // Adds an evaluated leaf's actions and opens the leaf for trials; false if they do not fit. Only by who has
  // claimed it. The leaf's rows have to stay.
  bool expand(std::size_t thread, Node& leaf, const LeafResult& result);

  // An expanded node's action with the largest score, and the one that comes after another in falling order
  // if it can be better than what the node has.
  ActionChoice best_action(const Node& node, const ActionRule& rule) const;
  ActionChoice next_action(const Node& node, const ActionRule& rule, const ActionChoice& last) const;
  ActionRule action_rule(const Node& node, const BranchRule& rule) const;

  // An action's children, made if they are not there yet; null if there is no room.
  ActionTable* open_action(std::size_t thread, const Node& node, std::uint32_t action);

  // Of an action's children with excess uncertainty (Equation 9) the one where it is largest, less what
  // trials in flight take; the first of equals.
  ChildChoice best_child(ActionTable& table, const BranchRule& rule) const;
  BranchRule branch_rule(const BranchRatios& ratios) const;

  // POMCP's choice. `best_value` gives the action of the largest mean value with UCB1's bonus, of c times
  // that of all scenarios (0: the best there is); `draw_child` a group by its share of so many scenarios.
  std::uint32_t best_value(const Node& node, double exploration) const;
  double mean_value(const Node& node, std::uint32_t action) const;
  Child& draw_child(ActionTable& table, std::uint32_t scenarios, std::uint32_t word) const;
  // Adds what a trial has earned that has come to `node`, for the actions that it took.
  void add_return(Node& node);

  // The child's node, made if it is not there yet; null if there is no room.
  Node* visit(std::size_t thread, Node& parent, std::uint32_t action, ActionTable& table, Child& child);

  // A trial goes down to a node; it ends with `backup`, or with `leave` as if it had not come.
  void enter(Node& node) {
    node.child->traffic.fetch_add(Child::kVisit + 1, std::memory_order_relaxed);
    if (counts_actions_ && node.table != nullptr) node.table->visits.fetch_add(1, std::memory_order_relaxed);
  }
  void leave(Node& node) {
    node.child->traffic.fetch_sub(Child::kVisit + 1, std::memory_order_relaxed);
    if (counts_actions_ && node.table != nullptr) node.table->visits.fetch_sub(1, std::memory_order_relaxed);
  }

  // Keeps trials from a node until it, or one below it, is expanded; false if it was closed before. Who
  // closes a leaf that has not been expanded meanwhile expands it. Who closes an expanded node has to look
  // once more whether all below is closed, and to open it if not.
  bool close(Node& node) { return !node.child->closed.exchange(true); }
  void open(Node& node);
  bool is_closed(const Node& node) const { return node.child->closed.load(); }

  // Whether an ancestor's default policy is as good as anything the node could add (Equation 12).
  bool is_blocked(const Node& node) const;

  // Makes what the node has its whole future (Algorithm 3, MAKE-DEFAULT): the default policy, if it is not
  // expanded.
  void make_default(Node& node);

  // Ends a trial at `node`: updates bounds from there up to the root (Equations 14 to 16).
  void backup(Node& node);

  // Of an expanded node's action: what its children's lower bounds come to with the reward.
  double action_lower(const Node& node, std::uint32_t action) const;
  // Its children, if a trial has looked at it; otherwise null.
  const ActionTable* table(const Expansion& expansion, std::uint32_t action) const;
  bool is_regularised() const { return pruning_ > 0.0; }
  bool counts_actions() const { return counts_actions_; }
  bool keeps_values() const { return keeps_values_; }
  double pruning() const { return pruning_; }
  // What one scenario at that depth counts of the root's value: gamma^depth / K.
  double weight(int depth) const;

  // How many nodes a thread has made so far, and of the groups that it was the first to look at, how many had
  // an upper bound below what the default policy earns.
  std::uint64_t nodes(std::size_t thread) const { return makers_[thread].nodes.get(); }
  std::uint64_t crossed(std::size_t thread) const { return makers_[thread].crossed.get(); }
  // Calls `visitor` with each node, in the order in which each thread made its own.
  template <class Visitor>
  void for_each_node(Visitor&& visitor) const {
    for (const Maker& maker : makers_) {
      for (const Node* node = maker.first; node != nullptr; node = node->next_made) visitor(*node);
    }
  }

  // The hash of the whole tree: for each node in creation order its parent, action, child index, scenarios,
  // visits and bounds.
  std::uint64_t signature(std::uint64_t seed) const;

 private:
  // A thread's own: where it takes memory, and what it has made. On lines of its own.
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
  bool counts_actions_;
  bool keeps_values_;
  double scenario_share_ = 0.0;  // 1 / K
};

}  // namespace hypgen
