// SPDX-License-Identifier: Apache-2.0
// POMCP (Silver and Veness, "Monte-Carlo Planning in Large POMDPs", NeurIPS 2010) over the same tree and
// evaluator. A trial chooses actions by mean return and UCB1, and the observation of a random scenario.
//
// A leaf's value is the default policy's return on all of its scenarios. The expansion of the leaf's parent
// has computed it. So a trial knows its return when it comes to a leaf, and adds it before the expansion.
#include <algorithm>
#include <cmath>
#include <limits>

#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/search/monotone.hpp"
#include "hypgen/search/search_thread.hpp"

namespace hypgen {

namespace {

// The site of POMCP's draws. Sites of a model are hashes, and none is equal to it.
constexpr std::uint32_t kSite = 0x706f6d63;

std::uint32_t draw(StreamKey key, std::size_t thread, std::uint64_t trial, int depth) {
  const PhiloxBlock counter{{static_cast<std::uint32_t>(trial), static_cast<std::uint32_t>(depth), kSite,
                             static_cast<std::uint32_t>(thread)}};
  return philox(key.key0, key.key1, counter).words[0];
}

}  // namespace

// The default policy's return after the action counts as the first trial's return.
double Tree::mean_value(const Node& node, std::uint32_t action) const {
  const Expansion& expansion = *node.expanded();
  const ActionTable* const opened = table(expansion, action);
  const double visits = opened == nullptr ? 0.0 : opened->visits.load(std::memory_order_relaxed);
  return expansion.value_sums()[action].load(std::memory_order_relaxed) / (1.0 + visits);
}

std::uint32_t Tree::best_value(const Node& node, double exploration) const {
  const Expansion& expansion = *node.expanded();
  const Child& child = *node.child;
  const auto visits = static_cast<float>(std::max<std::uint64_t>(1, child.visits()));
  // The bonus is weighted, as the values are.
  const double bonus =
      exploration * weight(node.depth) * child.count * std::sqrt(static_cast<double>(math::log(visits)));
  std::uint32_t best = kNoIndex;
  double best_score = -std::numeric_limits<double>::infinity();
  for (std::uint32_t a = 0; a < expansion.action_count; ++a) {
    const double score = mean_value(node, a) + explored(expansion, a, {bonus, 0.0});
    if (!(score > best_score)) continue;
    best_score = score;
    best = a;
  }
  return best;
}

Child& Tree::draw_child(ActionTable& table, std::uint32_t scenarios, std::uint32_t word) const {
  auto left = static_cast<std::uint32_t>((std::uint64_t{word} * scenarios) >> 32);
  Child* child = table.begin();
  for (; left >= child->count; ++child) left -= child->count;
  return *child;
}

// The value below a node is scaled to the parent's scenarios, as if all of them had gone the same way.
void Tree::add_return(Node& from) {
  double value = from.child->lower.load();
  for (Node* node = &from; node->parent != nullptr; node = node->parent) {
    const Node& parent = *node->parent;
    Expansion& expansion = *parent.expanded();
    const double reward = weight(parent.depth) * number(expansion.rows[node->action].reward_sum);
    value = reward + value * parent.child->count / node->child->count;
    add(expansion.value_sums()[node->action], value);
  }
}

// One trial (Algorithm 1, SIMULATE). It ends at a leaf, at the depth limit or at a node without a gap. A leaf
// that another trial has in expansion ends it too, with the leaf's value.
SearchThread::Progress SearchThread::walk_by_values(Node* node) {
  const double exploration = shared_.options.exploration * std::max(0.0, tree_.root().child->gap());
  bool is_full = false;
  while (node->expanded() != nullptr) {
    const std::uint32_t action = tree_.best_value(*node, exploration);
    if (action == kNoIndex) break;
    ActionTable* const table = tree_.open_action(number_, *node, action);
    Node* next = nullptr;
    if (table != nullptr) {
      const std::uint32_t word = draw(shared_.setup.key, number_, counts_.trials.get(), node->depth);
      next = tree_.visit(number_, *node, action, *table, tree_.draw_child(*table, node->child->count, word));
    }
    is_full = next == nullptr;
    if (is_full) break;
    tree_.enter(*next);
    node = next;
    if (node->depth >= shared_.setup.depth_limit) tree_.make_default(*node);
    if (!(node->child->gap() > 0.0)) break;
    if (node->expanded() == nullptr && claim(*node)) {
      tree_.add_return(*node);
      push({node, true});
      return Progress::kRequested;
    }
  }
  tree_.add_return(*node);
  backup(*node);
  failure_ = Status::kMemoryFull;
  return is_full ? Progress::kFailed : Progress::kEnded;
}

}  // namespace hypgen
