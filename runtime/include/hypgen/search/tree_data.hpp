// What a search tree is made of, and how its threads share it.
//
// Objects are made in a ChunkPool and published by one atomic store or compare-exchange; from then on they
// stay until the tree is reset, and no thread walks in it then. `Plain` fields are written before that only.
// Atomic ones say who writes them; without another word their accesses are sequentially consistent, because
// the protocols in tree.hpp rest on "of two threads one sees what the other has done".
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

// A group of scenarios below an action: the bounds of its belief, and the node once a trial visits it.
struct alignas(kCacheLine) Child {
  // On the regularised value (mu and l). Falls, by whoever finds a smaller one; rises only to `lower`, where
  // that has passed it. Who moves a bound adds the difference to the parent's action.
  std::atomic<double> upper;
  std::atomic<double> lower;         // rises
  std::atomic<double> plain_upper;   // without regularisation (U), kept only with it; as `upper`
  double default_value;              // l0, weighted: what the default policy earns. Plain, as the next two
  std::uint32_t first;               // the first of its scenarios: a position among the parent's
  std::uint32_t count;               // scenarios
  std::atomic<Node*> node{nullptr};  // set once, from null, by compare-exchange: acq_rel, read with acquire
  // Trials that have passed, N(b), in the upper 40 bits; those in flight in the lower 24. Relaxed: a count.
  std::atomic<std::uint64_t> traffic{0};
  // Everything that a trial could take below it is in expansion, or it is itself. Set by whoever finds that
  // out or claims the leaf, cleared by whoever opens something below.
  std::atomic<bool> closed{false};

  double gap() const { return upper.load() - lower.load(); }
  std::uint64_t visits() const { return traffic.load(std::memory_order_relaxed) / kVisit; }
  std::uint64_t in_flight() const { return traffic.load(std::memory_order_relaxed) % kVisit; }

  static constexpr std::uint64_t kVisit = std::uint64_t{1} << 24;
};
static_assert(sizeof(Child) == kCacheLine);

// An action that trials have looked at, with its groups.
struct alignas(kCacheLine) ActionTable {
  std::atomic<double> lower;  // reward and the children's lower bounds: added to by who moves one of those
  std::uint32_t count;        // of children. Plain
  // Trials that have gone on to one of them, those in flight too; kept if the tree counts them. Relaxed.
  std::atomic<std::uint32_t> visits;

  Child* children() { return reinterpret_cast<Child*>(this + 1); }
  const Child* children() const { return reinterpret_cast<const Child*>(this + 1); }
  Child* begin() { return children(); }
  Child* end() { return children() + count; }
  const Child* begin() const { return children(); }
  const Child* end() const { return children() + count; }
};

// What is known of a node's actions, in the order of the evaluator's rows.
struct alignas(kCacheLine) Expansion {
  std::uint64_t handle;        // the evaluator's. Plain, as all up to `arrays`
  const ActionRow* rows;       // of its actions, the evaluator's
  const ChildRow* child_rows;  // of their groups
  std::uint32_t action_count;
  std::uint32_t arrays;  // of numbers by action: 2 with regularisation or values, otherwise 1
  std::atomic<double> largest{
      -std::numeric_limits<double>::infinity()};  // of the upper bounds: the result of a scan
  // The place of the largest upper bound, the first of equals; kNoIndex: no action is legal. Whoever lowers
  // that bound scans. For those who walk down it is a hint.
  std::atomic<std::uint32_t> best{kNoIndex};
  std::atomic<std::uint32_t> rises{0};  // how often an upper bound has risen

  // Reward and the children's upper bounds: added to by who moves one of those.
  std::atomic<double>* uppers() { return reinterpret_cast<std::atomic<double>*>(this + 1); }
  const std::atomic<double>* uppers() const { return reinterpret_cast<const std::atomic<double>*>(this + 1); }
  // The same without regularisation, if the tree is regularised.
  std::atomic<double>* plain_uppers() { return uppers() + action_count; }
  const std::atomic<double>* plain_uppers() const { return uppers() + action_count; }
  // POMCP's: what the default policy earns after the action, and what each trial that took it has earned,
  // each as if of all scenarios. Added to by a trial that has ended, after it has raised the visits.
  std::atomic<double>* value_sums() { return uppers() + action_count; }
  const std::atomic<double>* value_sums() const { return uppers() + action_count; }
  // Each set once, from none, by compare-exchange: acq_rel, read with acquire.
  using Table = std::atomic<Ref<ActionTable>>;
  Table* tables() { return reinterpret_cast<Table*>(uppers() + arrays * action_count); }
  const Table* tables() const { return reinterpret_cast<const Table*>(uppers() + arrays * action_count); }

  static std::size_t bytes(std::size_t actions, std::size_t arrays) {
    return sizeof(Expansion) + actions * (arrays * sizeof(std::atomic<double>) + sizeof(Table));
  }
};
static_assert(sizeof(Expansion) == kCacheLine);
static_assert(std::atomic<Ref<ActionTable>>::is_always_lock_free && std::atomic<double>::is_always_lock_free);

// A visited belief. Its bounds live in its child. All but `expansion` is plain.
struct Node {
  // Set once, from null, by the thread that claimed the leaf: release, read with acquire.
  std::atomic<Expansion*> expansion{nullptr};
  Child* child = nullptr;           // its own
  Node* parent = nullptr;           // null at the root
  ActionTable* table = nullptr;     // the parent's action it is below, of that table's children
  std::uint32_t action = kNoIndex;  // that action's place
  std::uint32_t number = 0;         // among the nodes of the thread that made it
  int depth = 0;
  Node* next_made =
      nullptr;  // by that thread. Written when it is made: not published with the node before it, so to
                // be read while all threads are parked

  Expansion* expanded() const { return expansion.load(std::memory_order_acquire); }
};

}  // namespace hypgen
