// Tree search with several trials in flight.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hypgen/decision.hpp"
#include "hypgen/leaf_evaluator.hpp"
#include "hypgen/tree.hpp"

namespace hypgen {

// Keeps up to F trials in flight, in a queue: the oldest is waited for and applied before another starts in
// its place, so that the tree depends on F and never on when the evaluator answers. A trial whose leaf is
// expanded goes on down and to the end of the queue; one that ends without a leaf keeps its place in it. With
// F = 1 this is DESPOT. Allocates only when it is made.
class Search {
 public:
  Search(const PlannerOptions& options, const TreeOptions& tree);

  // Searches until a limit is reached or something fails, and fills `decision` but for its action. What is
  // then still in flight is released. `leaf_sizes` counts expansions by their scenarios.
  void run(LeafEvaluator& evaluator, const RootResult& root, const SearchSetup& setup, Decision& decision,
           std::vector<std::uint64_t>& leaf_sizes);

  // The best lower bound; the default policy's action if it is as good, or if following the policy is.
  int best_action(int default_action) const;

  const Tree& tree() const { return tree_; }

 private:
  // A trial in flight.
  struct Trial {
    Node* node;  // where it is
    bool waits;  // for that node's expansion; otherwise it has ended
  };
  // How far a trial came.
  enum class Progress {
    kRequested,  // to a leaf that has to be expanded
    kEnded,
    kWithoutEffect,  // it ended where it began
    kBackedOut,      // all that it could take is in expansion
    kFull,
  };
  // Where a trial goes on from a node.
  struct Branch {
    enum { kTaken, kStop, kClosed, kFull } kind;
    std::uint32_t action;
    ActionTable* table;
    Child* child;
  };

  Status advance();
  Status start_trial();
  Status apply_oldest();
  Status expand_oldest(Node*& node);
  Status wait(LeafResult& leaf);
  void send();
  Progress walk(Node* node, bool has_expanded);
  Branch choose(Node& node, const ChildRule& rule);
  Branch look(const Node& node, const ChildRule& rule);
  LeafRequest request(const Node& node) const;
  void push(Trial trial);
  Trial pop();
  Trial& in_queue(std::size_t i) { return queue_[(head_ + i) % queue_.size()]; }
  void abandon();

  PlannerOptions options_;
  Tree tree_;
  std::vector<Trial> queue_;  // a ring
  std::size_t head_ = 0;
  std::size_t size_ = 0;
  std::size_t sent_ = 0;     // of the trials in the queue, from the oldest: the evaluator has their leaves
  std::size_t waiting_ = 0;  // of the trials in the queue
  std::vector<LeafRequest> requests_;
  LeafEvaluator* evaluator_ = nullptr;
  SearchSetup setup_{};
  Decision* decision_ = nullptr;
  std::vector<std::uint64_t>* leaf_sizes_ = nullptr;
};

// Adds an expansion to what a decision and a planner count.
void count_expansion(const LeafResult& leaf, int depth, Decision& decision,
                     std::vector<std::uint64_t>& leaf_sizes);

}  // namespace hypgen
