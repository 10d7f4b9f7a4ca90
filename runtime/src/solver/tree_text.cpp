// SPDX-License-Identifier: Apache-2.0
#include "hypgen/solver/tree_text.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>
#include <unordered_set>
#include <utility>
#include <vector>

#include "hypgen/model/value_text.hpp"

namespace hypgen {

namespace {

using Json = nlohmann::ordered_json;

// Writes nodes from the root on.
class TreeWriter {
 public:
  TreeWriter(const EmbeddedModel& model, const KeyCodec& codec, const Tree& tree, ScenarioWalk& walk,
             const TreeExtent& extent)
      : model_(model), codec_(codec), tree_(tree), walk_(walk), extent_(extent) {
    choose_open();
  }

  std::size_t shown() const { return shown_; }

  Json root() {
    Json json = {{"pruning", tree_.pruning()}};
    json.update(node(tree_.root(), tree_.root().child->count));
    return json;
  }

 private:
  double scale(const Child& child, int depth) const {
    return 1.0 / (tree_.weight(depth) * tree_.scenarios(child));
  }

  // A group's bounds, and its share of the scenarios of the node above.
  Json bounds(const Child& child, std::uint32_t of, int depth) const {
    return {{"scenarios", tree_.scenarios(child)},
            {"share", static_cast<double>(child.count) / of},
            {"visits", child.visits()},
            {"lower", scale(child, depth) * child.lower.load()},
            {"upper", scale(child, depth) * child.upper.load()}};
  }

  // What is told below a node, if it is told.
  std::size_t cost(const Node& node) const {
    std::size_t sum = 0;
    for (const std::uint32_t place : most_visited(*node.expanded())) {
      const ActionTable* const table = tree_.table(*node.expanded(), place);
      sum += 1 + (table == nullptr ? 0 : std::min(children_by_size(*table).size(), extent_.most));
    }
    return sum;
  }

  // Chooses the nodes whose actions are told, as many as the extent has room for. A node has as many visits as
  // any below it, so that the most visited ones are found from the root down.
  void choose_open() {
    using Waiting = std::pair<std::uint64_t, const Node*>;
    const auto is_later = [](const Waiting& a, const Waiting& b) { return a.first < b.first; };
    std::vector<Waiting> heap = {{tree_.root().child->visits(), &tree_.root()}};
    std::size_t left = extent_.nodes - 1;
    while (!heap.empty() && left > 0) {
      std::pop_heap(heap.begin(), heap.end(), is_later);
      const Node& node = *heap.back().second;
      heap.pop_back();
      if (node.expanded() == nullptr || node.depth >= extent_.depth) continue;
      const std::size_t needed = cost(node);
      if (needed > left) continue;
      left -= needed;
      open_.insert(&node);
      for (const std::uint32_t place : most_visited(*node.expanded())) {
        const ActionTable* const table = tree_.table(*node.expanded(), place);
        if (table == nullptr) continue;
        const std::vector<const Child*> children = children_by_size(*table);
        for (std::size_t i = 0; i < std::min(children.size(), extent_.most); ++i) {
          const Node* const below = children[i]->node.load(std::memory_order_acquire);
          if (below == nullptr) continue;
          heap.emplace_back(children[i]->visits(), below);
          std::push_heap(heap.begin(), heap.end(), is_later);
        }
      }
    }
  }

  // The walk is at the node.
  Json node(const Node& node, std::uint32_t of) {
    ++shown_;
    Json json = bounds(*node.child, of, node.depth);
    const Expansion* const expansion = node.expanded();
    if (expansion == nullptr || node.depth >= extent_.depth) return json;
    json["actions"] = Json::array();
    if (open_.count(&node) == 0) {
      json["actions_left_out"] = expansion->action_count;
      return json;
    }
    const std::vector<std::uint32_t> places = most_visited(*expansion);
    for (const std::uint32_t place : places) json["actions"].push_back(action(node, place));
    if (expansion->action_count > places.size())
      json["actions_left_out"] = expansion->action_count - places.size();
    return json;
  }

  std::uint64_t visits(const Expansion& expansion, std::uint32_t place) const {
    const ActionTable* const table = tree_.table(expansion, place);
    if (table == nullptr) return 0;
    return std::accumulate(table->begin(), table->end(), std::uint64_t{0},
                           [](std::uint64_t sum, const Child& child) { return sum + child.visits(); });
  }

  // The places of the actions that trials took most; of equals those with the higher bounds go first.
  std::vector<std::uint32_t> most_visited(const Expansion& expansion) const {
    std::vector<std::uint32_t> places(expansion.action_count);
    std::iota(places.begin(), places.end(), 0U);
    std::vector<std::uint64_t> counts(places.size());
    for (const std::uint32_t place : places) counts[place] = visits(expansion, place);
    std::stable_sort(places.begin(), places.end(), [&](std::uint32_t a, std::uint32_t b) {
      return counts[a] != counts[b] ? counts[a] > counts[b]
                                    : expansion.uppers()[a].load() > expansion.uppers()[b].load();
    });
    places.resize(std::min(places.size(), extent_.most));
    return places;
  }

  // An action's groups, those with the most scenarios first.
  static std::vector<const Child*> children_by_size(const ActionTable& table) {
    std::vector<const Child*> children;
    for (const Child& child : table) children.push_back(&child);
    std::stable_sort(children.begin(), children.end(),
                     [](const Child* a, const Child* b) { return a->count > b->count; });
    return children;
  }

  Json action(const Node& node, std::uint32_t place) {
    ++shown_;
    const double scale = this->scale(*node.child, node.depth);
    const Expansion& expansion = *node.expanded();
    const int number = expansion.rows[place].action;
    Json json = {{"action", number},
                 {"name", model_.descriptor.action_names[static_cast<std::size_t>(number)]},
                 {"visits", visits(expansion, place)},
                 {"lower", scale * tree_.action_lower(node, place)},
                 {"upper", scale * expansion.uppers()[place].load()}};
    if (tree_.keeps_values() && node.parent == nullptr) json["mean"] = tree_.mean_value(node, place);
    const ActionTable* const table = tree_.table(expansion, place);
    if (table == nullptr) return json;
    json["groups"] = Json::array();
    const std::vector<const Child*> children = children_by_size(*table);
    const std::size_t shown = std::min(children.size(), extent_.most);
    for (std::size_t i = 0; i < shown; ++i) json["groups"].push_back(group(node, number, *children[i]));
    if (children.size() > shown) json["groups_left_out"] = children.size() - shown;
    return json;
  }

  Json group(const Node& parent, int action, const Child& child) {
    const ScenarioWalk::Seen seen = walk_.seen(action, child.first);
    const std::uint32_t of = parent.child->count;
    Json json = {{"terminal", seen.is_terminal}};
    std::vector<std::int32_t> values;
    if (!seen.is_terminal && codec_.decode({seen.key.data(), seen.key.size()}, values))
      json["seen"] = Json::parse(values_text(model_.seen, values));
    const Node* const below = child.node.load(std::memory_order_acquire);
    if (seen.is_terminal || below == nullptr) {
      ++shown_;
      json.update(bounds(child, of, parent.depth + 1));
      return json;
    }
    walk_.enter(action, child.first, child.count);
    json.update(node(*below, of));
    walk_.leave();
    return json;
  }

  const EmbeddedModel& model_;
  const KeyCodec& codec_;
  const Tree& tree_;
  ScenarioWalk& walk_;
  const TreeExtent& extent_;
  std::unordered_set<const Node*> open_;  // whose actions are told
  std::size_t shown_ = 0;
};

}  // namespace

std::size_t tree_size(const Tree& tree) {
  std::size_t size = 1;
  tree.for_each_node([&](const Node& node) {
    const Expansion* const expansion = node.expanded();
    if (expansion == nullptr) return;
    size += expansion->action_count;
    for (std::uint32_t place = 0; place < expansion->action_count; ++place) {
      const ActionTable* const table = tree.table(*expansion, place);
      if (table != nullptr) size += static_cast<std::size_t>(table->end() - table->begin());
    }
  });
  return size;
}

TreeText tree_text(const EmbeddedModel& model, const KeyCodec& codec, const Tree& tree, ScenarioWalk& walk,
                   const TreeExtent& extent) {
  TreeWriter writer(model, codec, tree, walk, extent);
  const std::string json = writer.root().dump();
  return {json, writer.shown()};
}

}  // namespace hypgen
