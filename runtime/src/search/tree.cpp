// SPDX-License-Identifier: Apache-2.0
#include "hypgen/search/tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "hypgen/model/model.hpp"
#include "hypgen/search/atomic_maximum.hpp"
#include "hypgen/search/signature.hpp"

namespace hypgen {

namespace {

constexpr double kRounding = 1e-6;

}  // namespace

std::size_t TreeOptions::expansion_bytes(std::size_t actions) const {
  constexpr std::size_t kGroups = 2, kLookedAt = 2;  // of most actions no trial ever makes the children
  const bool is_regularised = pruning > 0.0;
  const std::size_t tables = is_regularised ? actions : std::min(actions, kLookedAt);
  return Expansion::bytes(actions, is_regularised || keeps_values ? 2 : 1) + sizeof(Node) +
         tables * (sizeof(ActionTable) + kGroups * sizeof(Child));
}

Tree::Tree(const TreeOptions& options)
    : pool_(options.memory_bytes, options.threads),
      makers_(options.threads, Maker(pool_)),
      pruning_(options.pruning),
      unit_(math::power_of_two(-options.reward_bits)),
      scale_(reward_scale(options.reward_bits)),
      counts_actions_(options.counts_actions),
      keeps_values_(options.keeps_values) {
  double power = 1.0;
  for (int depth = 0; depth <= options.max_depth; ++depth, power *= options.discount) {
    discounts_.push_back(power);
  }
}

double Tree::weight(int depth) const { return discounts_[static_cast<std::size_t>(depth)] * scenario_share_; }

void Tree::clear() {
  pool_.reset();
  for (Maker& maker : makers_) maker = Maker(pool_);
  root_ = nullptr;
}

bool Tree::reset(const ChildRow& row, std::uint32_t units) {
  clear();
  unit_scenarios_ = 1.0 / units;
  scenario_share_ = 1.0 / (row.count * unit_scenarios_);
  Maker& maker = makers_[0];
  Child* const child = get(maker.memory.take<Child>());
  root_ = get(maker.memory.take<Node>());
  if (root_ == nullptr) return false;
  maker.crossed.set(make_child(child, row, 0));
  root_ = new (root_) Node;
  root_->child = child;
  child->node.store(root_, std::memory_order_relaxed);
  maker.first = maker.last = root_;
  maker.nodes.set(1);
  return true;
}

// Gives the number of groups whose bounds crossed: 0 or 1.
std::uint64_t Tree::make_child(Child* place, const ChildRow& row, int depth) const {
  const double share = weight(depth);
  const double lower = share * number(row.lower_sum);
  double upper = share * number(row.upper_sum);
  std::uint64_t crossed = 0;
  if (upper < lower) {
    // Bounds that differ by rounding alone have not crossed.
    crossed = lower - upper > kRounding * (share * row.count * unit_scenarios_ * scale_ + std::abs(upper));
    upper = lower;
  }
  // A subtree costs lambda at least, or is the default policy.
  Child& child = *new (place) Child;
  child.upper.store(std::max(lower, upper - pruning_), std::memory_order_relaxed);
  child.lower.store(lower, std::memory_order_relaxed);
  child.plain_upper.store(upper, std::memory_order_relaxed);
  child.default_value = lower;
  child.first = row.first;
  child.count = row.count;
  return crossed;
}

bool Tree::expand(std::size_t thread, Node& leaf, const LeafResult& result) {
  Expansion* const expansion = make_expansion(makers_[thread], result);
  if (expansion == nullptr) return false;
  double lower = 0.0;
  if (!is_regularised()) {
    lower = set_uppers(*expansion, leaf.depth);
  } else if (!set_regularised_uppers(thread, leaf, *expansion, lower)) {
    return false;
  }
  if (expansion->action_count > 0) {
    const Largest best = largest(expansion->uppers(), expansion->action_count);
    expansion->largest.store(best.value, std::memory_order_relaxed);
    expansion->best.store(best.place, std::memory_order_relaxed);
  }
  if (keeps_values_) {
    for (std::uint32_t a = 0; a < expansion->action_count; ++a)
      new (expansion->value_sums() + a) std::atomic<double>(row_lower(expansion->rows[a], leaf.depth));
  }
  leaf.expansion.store(expansion, std::memory_order_release);
  refresh(leaf, lower);
  open(leaf);
  return true;
}

Expansion* Tree::make_expansion(Maker& maker, const LeafResult& result) const {
  const std::size_t actions = result.actions.size();
  const std::uint32_t arrays = is_regularised() || keeps_values_ ? 2 : 1;
  Expansion* const place = get(maker.memory.take<Expansion>(Expansion::bytes(actions, arrays)));
  if (place == nullptr) return nullptr;
  Expansion* const expansion = new (place) Expansion;
  expansion->handle = result.handle;
  expansion->rows = result.actions.begin();
  expansion->child_rows = result.children.begin();
  expansion->action_count = static_cast<std::uint32_t>(actions);
  expansion->arrays = arrays;
  for (std::size_t a = 0; a < actions; ++a)
    new (expansion->tables() + a) Expansion::Table{Ref<ActionTable>{}};
  return expansion;
}

double Tree::row_lower(const ActionRow& row, int depth) const {
  return weight(depth) * number(row.reward_sum) + weight(depth + 1) * number(row.lower_sum);
}

// Sets the upper bounds of a leaf's actions from the rows' sums; gives the largest lower bound.
double Tree::set_uppers(Expansion& expansion, int depth) const {
  const double reward_share = weight(depth), share = weight(depth + 1);
  double best = -std::numeric_limits<double>::infinity();
  for (std::uint32_t a = 0; a < expansion.action_count; ++a) {
    const ActionRow& row = expansion.rows[a];
    const double reward = reward_share * number(row.reward_sum);
    best = std::max(best, reward + share * number(row.lower_sum));
    new (expansion.uppers() + a) std::atomic<double>(reward + share * number(row.upper_sum));
  }
  return best;
}

// The same with regularisation. Each child has a penalty of its own, so this makes all children; false if
// they do not fit.
bool Tree::set_regularised_uppers(std::size_t thread, Node& node, Expansion& expansion, double& lower) {
  lower = -std::numeric_limits<double>::infinity();
  for (std::uint32_t a = 0; a < expansion.action_count; ++a) {
    ActionTable* const table = make_table(thread, expansion, node.depth, a);
    if (table == nullptr) return false;
    const double reward = weight(node.depth) * number(expansion.rows[a].reward_sum);
    double upper_sum = reward - pruning_, lower_sum = reward - pruning_, plain_sum = reward;
    for (const Child& child : *table) {
      upper_sum += child.upper.load();
      lower_sum += child.lower.load();
      plain_sum += child.plain_upper.load();
    }
    table->lower.store(lower_sum);
    new (expansion.uppers() + a) std::atomic<double>(upper_sum);
    new (expansion.plain_uppers() + a) std::atomic<double>(plain_sum);
    lower = std::max(lower, lower_sum);
  }
  return true;
}

ActionTable* Tree::open_action(std::size_t thread, const Node& node, std::uint32_t action) {
  Expansion& expansion = *node.expanded();
  const Ref<ActionTable> there = expansion.tables()[action].load(std::memory_order_acquire);
  return there ? get(there) : make_table(thread, expansion, node.depth, action);
}

// Makes an action's children. Gives another thread's table if that was published first; null if there is no
// room.
ActionTable* Tree::make_table(std::size_t thread, Expansion& expansion, int depth, std::uint32_t action) {
  Maker& maker = makers_[thread];
  const ActionRow& row = expansion.rows[action];
  const Ref<ActionTable> made =
      maker.memory.take<ActionTable>(sizeof(ActionTable) + row.child_count * sizeof(Child));
  if (!made) return nullptr;
  ActionTable* const table = new (get(made)) ActionTable{{row_lower(row, depth)}, row.child_count, {0}};
  std::uint64_t crossed = 0;
  for (std::uint32_t i = 0; i < table->count; ++i) {
    crossed += make_child(table->children() + i, expansion.child_rows[row.first_child + i], depth + 1);
  }
  Ref<ActionTable> there{};
  if (!expansion.tables()[action].compare_exchange_strong(there, made, std::memory_order_acq_rel)) {
    maker.memory.take_back(made);
    return get(there);
  }
  maker.crossed.add(crossed);
  return table;
}

const ActionTable* Tree::table(const Expansion& expansion, std::uint32_t action) const {
  return get(expansion.tables()[action].load(std::memory_order_acquire));
}

double Tree::action_lower(const Node& node, std::uint32_t action) const {
  const Expansion& expansion = *node.expanded();
  const ActionTable* const opened = table(expansion, action);
  return opened != nullptr ? opened->lower.load() : row_lower(expansion.rows[action], node.depth);
}

Node* Tree::visit(std::size_t thread, Node& parent, std::uint32_t action, ActionTable& table, Child& child) {
  Node* there = child.node.load(std::memory_order_acquire);
  if (there != nullptr) return there;
  Maker& maker = makers_[thread];
  const Ref<Node> made = maker.memory.take<Node>();
  if (!made) return nullptr;
  Node* const node = new (get(made)) Node;
  node->child = &child;
  node->parent = &parent;
  node->table = &table;
  node->action = action;
  node->number = static_cast<std::uint32_t>(maker.nodes.get());
  node->depth = parent.depth + 1;
  if (!child.node.compare_exchange_strong(there, node, std::memory_order_acq_rel)) {
    maker.memory.take_back(made);
    return there;
  }
  maker.nodes.add(1);
  (maker.last == nullptr ? maker.first : maker.last->next_made) = node;
  maker.last = node;
  return node;
}

std::uint64_t Tree::signature(std::uint64_t seed) const {
  Signature hash(seed);
  if (scale_ != 1.0) hash.add(unit_);
  for_each_node([&](const Node& node) {
    const Child& child = *node.child;
    hash.add(std::uint64_t{node.parent != nullptr ? node.parent->number : kNoIndex});
    if (node.parent != nullptr) {
      hash.add(static_cast<std::uint64_t>(node.parent->expanded()->rows[node.action].action));
      hash.add(static_cast<std::uint64_t>(node.child - node.table->children()));
    }
    hash.add(std::uint64_t{child.count});
    hash.add(child.visits());
    hash.add(child.upper.load());
    hash.add(child.lower.load());
  });
  return hash.value();
}

}  // namespace hypgen
