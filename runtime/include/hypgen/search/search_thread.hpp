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

// What the threads of a search share besides the tree. Plain fields are written while all are parked.
struct SharedSearch {
  SharedSearch(const PlannerOptions& planner, const TreeOptions& tree_options)
      : options(planner), tree(tree_options) {}

  // Starts a search, up to the root's expansion. While all threads are parked.
  void begin(LeafEvaluator& leaf_evaluator, const RootResult& root, const SearchSetup& search_setup,
             Span<const int> actions);

  // Asks all threads to end. The first reason stays, but for one that the planner has to act on.
  void stop(Status reason);
  bool is_stopped() const { return status.load() != Status::kOk; }

  // Hands out the number of one more trial; false if there are no more.
  bool take_trial();
  void give_trial_back();

  // The whole part of a thread in a search; nothing if the evaluator does not serve that many.
  void run_thread(std::size_t number);

  const PlannerOptions options;
  Tree tree;
  LeafEvaluator* evaluator = nullptr;
  Span<const int> root_actions{};  // none: all that are legal
  SearchSetup setup{};
  bool has_crossed_at_root = false;  // the root's own bounds
  std::vector<std::unique_ptr<SearchThread>> threads;
  // Written once or twice a search, read all the time.
  alignas(kCacheLine) std::atomic<Status> status{Status::kOk};  // kOk: go on
  // Handed out so far, at most the limit; used only if there is one. Relaxed: a count. A thread that gives
  // one back goes on itself, so that all trials are done; others that saw none left have ended, while each of
  // those that were missing was in another thread's hands: at most one a thread.
  alignas(kCacheLine) std::atomic<std::uint64_t> trials{0};
};

// Keeps up to F trials in flight, in a queue: the oldest is waited for and applied before another starts in
// its place, so that the tree of a single thread depends on F and never on when the evaluator answers. A
// trial whose leaf is expanded goes on down and to the end of the queue; one that ends without a leaf keeps
// its place in it. One thread with F = 1 is DESPOT. Allocates only when it is made.
class alignas(kCacheLine) SearchThread {
 public:
  SearchThread(SharedSearch& shared, std::size_t number, std::size_t in_flight);

  // Forgets the previous search. Only while it is parked, as is all below but for `run`.
  void reset();

  // Expands the root: by one thread, before any runs.
  void expand_root();

  // Searches until the search stops or all trials are done.
  void run();

  // What it has done in this search so far.
  const SearchCounts& counts() const { return counts_; }
  // Its expansions since it was made: entry n counts leaves with n scenarios.
  const std::vector<std::uint64_t>& leaf_sizes() const { return leaf_sizes_; }

 private:
  // One walk in so many is timed: to read the clock takes up to a quarter of what a walk does. A prime, as
  // walks come in patterns.
  static constexpr unsigned kTimedWalks = 67;

  // A trial in flight.
  struct Trial {
    Node* node;  // where it is
    bool waits;  // for that node's expansion; otherwise it has ended
  };
  // How far a trial came.
  enum class Progress {
    kRequested,  // to a leaf that has to be expanded
    kEnded,
    kWithoutEffect,  // it found nothing left to do, and is not backed up
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
  Progress timed_walk(Node*& node, bool has_expanded);
  Progress walk(Node*& node, bool has_expanded);
  Progress walk_by_bounds(Node*& node, bool has_expanded);
  Progress walk_by_values(Node* node);
  void backup(Node& node);
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
  std::size_t sent_ = 0;     // of the trials in the queue, from the oldest: the evaluator has their leaves
  std::size_t waiting_ = 0;  // of the trials in the queue
  std::vector<LeafRequest> requests_;
  SearchCounts counts_;
  std::vector<std::uint64_t> leaf_sizes_;
  std::uint64_t rest_ = 0;  // what others had done when a trial last found nothing to do, and nobody had one
  unsigned walks_to_timed_ = kTimedWalks;
  bool is_timed_ = false;          // the present walk
  Clock::duration backup_time_{};  // of a timed walk
  unsigned pauses_ = 0;            // since it last found something to do
  // How many trials it has at hand, in the lower 16 bits, and how often it has said so. Written by this
  // thread with release after what it has done to the tree, read by others with acquire when they find
  // nothing to do.
  alignas(kCacheLine) std::atomic<std::uint64_t> activity_{0};
};

}  // namespace hypgen
