// SPDX-License-Identifier: Apache-2.0
// The data of a search tree, and how its threads share it.
//
// A thread makes an object in a ChunkPool and publishes it by one atomic store or compare-exchange. Published
// objects stay until the tree is reset, which happens while no thread is in it.
//
// The comments name two kinds of fields. The maker alone writes a *plain* field, before it publishes the
// object. Threads write an *atomic* field during the search. Its accesses are sequentially consistent unless
// the comment names another order, because the protocols of tree.hpp need one order of all of them: of two
// threads at least one sees what the other has done.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/memory/chunk_pool.hpp"

namespace hypgen {

constexpr std::uint32_t kNoIndex = UINT32_MAX;

struct Node;

// A group of scenarios below an action: the bounds of its belief, and its node once a trial has come.
struct alignas(kCacheLine) Child {
  // Bounds on the regularised value (mu and l). A thread that finds a smaller upper bound lowers it; it rises
  // only to a `lower` that has passed it. A thread that finds a larger lower bound raises that. The thread
  // that moves a bound adds the difference to the parent's action.
  std::atomic<double> upper;
  std::atomic<double> lower;
  // The upper bound without regularisation (U), in a regularised tree. Threads move it as `upper`.
  std::atomic<double> plain_upper;
  double default_value;  // plain, as the next two: what the default policy earns (l0), weighted
  std::uint32_t first;   // its first scenario: a position among the parent's
  std::uint32_t count;   // of its scenarios
  // The first trial that visits the group sets it, from null: compare-exchange acq_rel, read acquire.
  std::atomic<Node*> node{nullptr};
  // Upper 40 bits: trials that have visited the node, N(b). Lower 24 bits: trials in flight below it. Every
  // trial adds on its way down and subtracts when it ends. Relaxed, as it is a count.
  std::atomic<std::uint64_t> traffic{0};
  // True while the leaf, or everything that a trial could take below the node, is in expansion. The thread
  // that claims the leaf or finds everything taken sets it. A thread that opens a node below clears it.
  std::atomic<bool> closed{false};

  double gap() const { return upper.load() - lower.load(); }
  std::uint64_t visits() const { return traffic.load(std::memory_order_relaxed) / kVisit; }
  std::uint64_t in_flight() const { return traffic.load(std::memory_order_relaxed) % kVisit; }

  static constexpr std::uint64_t kVisit = std::uint64_t{1} << 24;
};
static_assert(sizeof(Child) == kCacheLine);

// An action that a trial has looked at. Its children follow it in memory.
struct alignas(kCacheLine) ActionTable {
  // The reward and the children's lower bounds. The thread that moves a child's bound adds the difference.
  std::atomic<double> lower;
  std::uint32_t count;  // of children; plain
  // Trials that have gone on to a child, trials in flight included, if the tree counts them. Every trial adds
  // on its way down. Relaxed, as it is a count.
  std::atomic<std::uint32_t> visits;

  Child* children() { return reinterpret_cast<Child*>(this + 1); }
  const Child* children() const { return reinterpret_cast<const Child*>(this + 1); }
  Child* begin() { return children(); }
  Child* end() { return children() + count; }
  const Child* begin() const { return children(); }
  const Child* end() const { return children() + count; }
};

// A node's actions, in the order of the evaluator's rows. Arrays of numbers by action follow it in memory.
struct alignas(kCacheLine) Expansion {
  std::uint64_t handle;        // the evaluator's name of the node; plain, as all up to `arrays`
  const ActionRow* rows;       // one for each action, in the evaluator's memory
  const ChildRow* child_rows;  // of the actions' groups, in the evaluator's memory
  std::uint32_t action_count;
  std::uint32_t arrays;  // how many arrays of numbers: 2 with regularisation or values, otherwise 1
  // The largest upper bound. The thread that scans replaces it by compare-exchange.
  std::atomic<double> largest{-std::numeric_limits<double>::infinity()};
  // The place of the largest upper bound, the first of equals; kNoIndex: no action is legal. The thread that
  // lowers that bound scans and stores the new place. Trials that walk down take it as a hint.
  std::atomic<std::uint32_t> best{kNoIndex};
  // How often an upper bound has risen. The thread that raises one adds.
  std::atomic<std::uint32_t> rises{0};

  // The reward and the children's upper bounds. The thread that moves a child's bound adds the difference.
  std::atomic<double>* uppers() { return reinterpret_cast<std::atomic<double>*>(this + 1); }
  const std::atomic<double>* uppers() const { return reinterpret_cast<const std::atomic<double>*>(this + 1); }
  // The same of the value without regularisation, in a regularised tree.
  std::atomic<double>* plain_uppers() { return uppers() + action_count; }
  const std::atomic<double>* plain_uppers() const { return uppers() + action_count; }
  // POMCP's: the default policy's return after the action, and the return of each trial that took the action,
  // each scaled to all scenarios. A trial raises the visits on its way down and adds its return at its end.
  std::atomic<double>* value_sums() { return uppers() + action_count; }
  const std::atomic<double>* value_sums() const { return uppers() + action_count; }
  // The first trial that looks at an action sets its table: compare-exchange acq_rel, read acquire.
  using Table = std::atomic<Ref<ActionTable>>;
  Table* tables() { return reinterpret_cast<Table*>(uppers() + arrays * action_count); }
  const Table* tables() const { return reinterpret_cast<const Table*>(uppers() + arrays * action_count); }

  static std::size_t bytes(std::size_t actions, std::size_t arrays) {
    return sizeof(Expansion) + actions * (arrays * sizeof(std::atomic<double>) + sizeof(Table));
  }
};
static_assert(sizeof(Expansion) == kCacheLine);
static_assert(std::atomic<Ref<ActionTable>>::is_always_lock_free && std::atomic<double>::is_always_lock_free);

// A visited belief. Its bounds stand in its child. All fields but `expansion` and `next_made` are plain.
struct Node {
  // The thread that has claimed the leaf sets it once, from null: release, read acquire.
  std::atomic<Expansion*> expansion{nullptr};
  Child* child = nullptr;           // its own
  Node* parent = nullptr;           // null at the root
  ActionTable* table = nullptr;     // the table of the parent's action that holds `child`
  std::uint32_t action = kNoIndex;  // the place of that action
  std::uint32_t number = 0;         // among the nodes of the thread that made it
  int depth = 0;
  // The next node of the thread that made this one. That thread writes it after it has published this node.
  // Others read it only while all threads are parked.
  Node* next_made = nullptr;

  Expansion* expanded() const { return expansion.load(std::memory_order_acquire); }
};

}  // namespace hypgen
