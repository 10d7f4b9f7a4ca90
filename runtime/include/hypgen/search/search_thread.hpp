// SPDX-License-Identifier: Apache-2.0
// One of the threads that search a tree.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/search/decision.hpp"
#include "hypgen/search/search_counts.hpp"
#include "hypgen/search/tree.hpp"

namespace hypgen {

class SearchThread;

// The data that the threads of a search share. The planner's thread writes the plain fields while all other
// threads are parked.
struct SharedSearch {
  SharedSearch(const PlannerOptions& planner, const TreeOptions& tree_options)
      : options(planner), tree(tree_options) {}

  // Starts a search and expands the root. All other threads are parked.
  void begin(LeafEvaluator& leaf_evaluator, const RootResult& root, const SearchSetup& search_setup,
             Span<const int> actions);

  // Asks all threads to end. The first reason stays, unless a later one is grave: a failure or a lost device.
  void stop(Status reason);
  bool is_stopped() const { return status.load() != Status::kOk; }

  // Counts one more trial; false if the limit is reached.
  bool take_trial();
  void give_trial_back();

  // Runs one thread's part of a search. A thread that the evaluator does not serve does nothing.
  void run_thread(std::size_t number);

  const PlannerOptions options;
  Tree tree;
  LeafEvaluator* evaluator = nullptr;
  Span<const int> root_actions{};  // none: all that are legal
  SearchSetup setup{};
  bool has_crossed_at_root = false;  // the model gives the root an upper bound below the lower one
  std::vector<std::unique_ptr<SearchThread>> threads;
  // Any thread replaces it, once or twice a search, by compare-exchange; all read it at each trial.
  // Sequentially consistent.
  alignas(kCacheLine) std::atomic<Status> status{Status::kOk};  // kOk: go on
  // Trials handed out so far, at most the limit; kept only if there is one. Any thread adds a trial, or takes
  // back one that it undoes. Relaxed, as it is a count. A thread that gives a trial back goes on itself, so
  // all trials are done. A thread that sees no trial left ends, though others may give back at most one each.
  alignas(kCacheLine) std::atomic<std::uint64_t> trials{0};
};

// A thread of a search. It keeps up to F trials in flight, in a queue. When the queue is full, the thread
// waits for the oldest trial's leaf and applies it. So the tree of a single thread depends on F alone, and
// not on when the evaluator answers. A trial whose leaf has been expanded goes on down, and to the end of the
// queue. A trial that ends without a leaf keeps its place until it is the oldest. One thread with F = 1 is
// DESPOT. Only the constructor allocates.
class alignas(kCacheLine) SearchThread {
 public:
  SearchThread(SharedSearch& shared, std::size_t number, std::size_t in_flight);

  // Forgets the previous search. The thread is parked during this and all calls below but `run`.
  void reset();

  // Expands the root. One thread does so before any runs.
  void expand_root();

  // Searches until the search stops or all trials are done.
  void run();

  // The thread's counts in this search so far.
  const SearchCounts& counts() const { return counts_; }
  // The thread's expansions in all searches: entry n counts leaves with n scenarios.
  const std::vector<std::uint64_t>& leaf_sizes() const { return leaf_sizes_; }

 private:
  // The thread times one walk in so many, because reading the clock takes up to a quarter of a walk. The
  // number is prime, because walks come in patterns.
  static constexpr unsigned kTimedWalks = 67;

  // So many leaves after a collision a thread takes the tree for a narrow one.
  static constexpr unsigned kCrowded = 32;

  // A trial in flight.
  struct Trial {
    Node* node;  // its deepest node
    bool waits;  // it waits for that node's expansion; false: it has ended
  };
  // The end of a walk.
  enum class Progress {
    kRequested,      // the trial has claimed a leaf, which waits for its expansion
    kEnded,          // the trial has been backed up
    kWithoutEffect,  // the trial found nothing to do, and has not been backed up
    kBackedOut,      // all that the trial could take is in expansion: it has left all nodes
    kFailed,         // `failure_` says why
  };
  // The branch by which a trial goes on from a node.
  struct Branch {
    enum Kind { kTaken, kStop, kClosed, kFull } kind;
    std::uint32_t action = kNoIndex;
    ActionTable* table = nullptr;
    Child* child = nullptr;
  };

  Status advance();
  Status start_trial();
  Status apply_oldest();
  bool is_ready(LeafResult& leaf);
  Status apply(const LeafResult& leaf);
  Status take(Node& node, const LeafResult& leaf);
  bool expands_here(Node& node, Status& failure);
  Status wait(LeafResult& leaf);
  void send();
  Progress timed_walk(Node*& node, bool has_expanded);
  Progress walk(Node*& node, bool has_expanded);
  Progress walk_by_bounds(Node*& node, bool has_expanded);
  Progress walk_by_values(Node* node);
  void backup(Node& node);
  void collide();
  bool claim(Node& leaf);
  Branch choose(Node& node, const BranchRule& rule);
  Branch look(const Node& node, const BranchRule& rule);
  LeafRequest request(const Node& node) const;
  void push(Trial trial);
  Trial pop();
  Trial& in_queue(std::size_t i) { return queue_[(head_ + i) % queue_.size()]; }
  void abandon();
  std::size_t at_hand() const;
  void publish(std::size_t at_hand);
  bool is_search_at_rest();
  Status undo_trial(Node* node, std::uint64_t activity);
  void idle();
  void pause();

  SharedSearch& shared_;
  Tree& tree_;
  const std::size_t number_;
  std::vector<Trial> queue_;  // a ring
  std::size_t head_ = 0;
  std::size_t size_ = 0;
  std::size_t sent_ = 0;     // trials, from the oldest, whose leaves the evaluator has
  std::size_t waiting_ = 0;  // trials in the queue that wait for an expansion
  std::vector<LeafRequest> requests_;
  SearchCounts counts_;
  std::vector<std::uint64_t> leaf_sizes_;
  std::uint64_t rest_ = 0;  // sum of the others' activity when this thread last found all of them idle
  unsigned walks_to_timed_ = kTimedWalks;
  bool is_timed_ = false;             // the thread times the present walk
  Clock::duration backup_time_{};     // of a timed walk
  Clock::duration expansion_time_{};  // the same
  bool has_expanded_here_ = false;    // this thread, in this search, a leaf that no device had
  unsigned crowded_ = 0;              // leaves until this thread forgets that it met what is in expansion
  Status failure_ = Status::kOk;      // of the last walk that failed
  unsigned pauses_ = 0;  // length of the last pause; 0: the thread has found something to do since
  // Lower 16 bits: trials that the thread has at hand. Upper bits: how often it has stored that number. Only
  // this thread writes it, during a search: release, after its changes to the tree. Others read it when they
  // find nothing to do: acquire.
  alignas(kCacheLine) std::atomic<std::uint64_t> activity_{0};
};

}  // namespace hypgen
