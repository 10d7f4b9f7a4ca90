// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/policy_graph.hpp"

#include <algorithm>
#include <queue>
#include <unordered_map>
#include <utility>

namespace hypgen::exact {

namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

// What can be seen after an action, and the belief then.
struct Seen {
  int observation;
  double probability;
  SparseBelief belief;
};

// `sums`: of columns; zeroes between calls.
std::vector<Seen> seen_after(const ExactModel& model, const SparseBelief& belief, int number,
                             std::vector<double>& sums) {
  const ExactAction& action = model.actions[index(number)];
  if (sums.size() < action.next.size()) sums.resize(action.next.size(), 0.0);
  std::vector<int> columns;
  for (SparseBelief::InnerIterator state(belief); state; ++state) {
    for (SparseMatrix::InnerIterator entry(action.outcomes, state.index()); entry; ++entry) {
      const double probability = state.value() * entry.value();
      if (!(probability > 0.0)) continue;
      double& sum = sums[static_cast<std::size_t>(entry.col())];
      if (sum == 0.0) columns.push_back(static_cast<int>(entry.col()));
      sum += probability;
    }
  }
  std::sort(columns.begin(), columns.end());  // and so are their observations
  std::vector<Seen> seen;
  std::size_t group = 0;
  for (auto column = columns.begin(); column != columns.end();) {
    while (action.begin[group + 1] <= *column) ++group;
    Seen one{action.observations[group], 0.0, SparseBelief(model.states)};
    for (; column != columns.end() && *column < action.begin[group + 1]; ++column) {
      double& sum = sums[index(*column)];
      one.belief.insertBack(action.next[index(*column)]) = sum;
      one.probability += sum;
      sum = 0.0;
    }
    one.belief /= one.probability;
    seen.push_back(std::move(one));
  }
  return seen;
}

class Walk {
 public:
  Walk(const ExactModel& model, const AlphaPolicy& policy, const WalkLimits& limits)
      : model_(model), policy_(policy), limits_(limits) {}

  PolicyGraph run() {
    for (std::size_t i = 0; i < model_.starts.size(); ++i) {
      graph_.starts.push_back({i, found(model_.starts[i].belief, model_.starts[i].probability)});
    }
    while (!waiting_.empty()) {
      if (places_.size() >= limits_.found || products_ > limits_.products || entries_ > limits_.entries) {
        graph_.is_cut_off = true;
        break;
      }
      const int place = waiting_.top().second;
      waiting_.pop();
      visit(place);
    }
    number();
    return std::move(graph_);
  }

 private:
  // A node that was found. Its belief goes once it has been visited.
  struct Place {
    const AlphaPolicy::Vector* vector;
    SparseBelief belief;
    double value;
    double reach;  // the probability of the way by which it was found
    int number = -1;
  };

  // The place of the vector that is best at the belief; -1 where nothing is legal.
  int found(const SparseBelief& belief, double reach) {
    double value = 0.0;
    const AlphaPolicy::Vector* const vector = policy_.best(belief, value);
    if (vector == nullptr) return -1;
    const std::size_t size = static_cast<std::size_t>(belief.nonZeros());
    products_ += static_cast<double>(size * policy_.vectors_at(belief));
    const auto [at, is_new] = place_of_.emplace(vector, static_cast<int>(places_.size()));
    if (is_new) {
      places_.push_back({vector, belief, value, reach});
      entries_ += size;
      waiting_.push({{reach, -at->second}, at->second});
    }
    return at->second;
  }

  void visit(int place) {
    const bool is_kept = graph_.nodes.size() < limits_.kept;
    const SparseBelief belief = std::move(places_[index(place)].belief);
    entries_ -= static_cast<std::size_t>(belief.nonZeros());
    const double reach = places_[index(place)].reach;
    GraphNode node{places_[index(place)].vector->action, places_[index(place)].value, 1.0, {}};
    for (const Seen& seen : seen_after(model_, belief, node.action, sums_)) {
      node.ends -= seen.probability;
      const int to = found(seen.belief, reach * seen.probability);
      if (is_kept) add(node, to, seen);
    }
    if (!is_kept) return;
    if (node.ends < 1e-12) node.ends = 0.0;  // what rounding leaves
    std::stable_sort(node.edges.begin(), node.edges.end(),
                     [](const GraphEdge& a, const GraphEdge& b) { return a.probability > b.probability; });
    for (GraphEdge& edge : node.edges) {
      std::stable_sort(edge.observations.begin(), edge.observations.end(),
                       [](const auto& a, const auto& b) { return a.second > b.second; });
    }
    places_[index(place)].number = static_cast<int>(graph_.nodes.size());
    graph_.nodes.push_back(std::move(node));
  }

  // Observations that lead to one place share an edge.
  void add(GraphNode& node, int to, const Seen& seen) {
    if (to < 0) {
      node.ends += seen.probability;
      return;
    }
    const auto edge = std::find_if(node.edges.begin(), node.edges.end(),
                                   [to](const GraphEdge& one) { return one.to == to; });
    if (edge == node.edges.end()) {
      node.edges.push_back({to, seen.probability, {{seen.observation, seen.probability}}});
    } else {
      edge->probability += seen.probability;
      edge->observations.emplace_back(seen.observation, seen.probability);
    }
  }

  // Turns places into the numbers of nodes.
  void number() {
    const auto number_of = [this](int place) { return place < 0 ? -1 : places_[index(place)].number; };
    for (GraphStart& start : graph_.starts) start.to = number_of(start.to);
    for (GraphNode& node : graph_.nodes) {
      for (GraphEdge& edge : node.edges) edge.to = number_of(edge.to);
    }
    graph_.left_out = places_.size() - graph_.nodes.size();
  }

  const ExactModel& model_;
  const AlphaPolicy& policy_;
  const WalkLimits& limits_;
  PolicyGraph graph_;
  double products_ = 0.0;
  std::size_t entries_ = 0;
  std::vector<double> sums_;
  std::vector<Place> places_;
  std::unordered_map<const AlphaPolicy::Vector*, int> place_of_;
  // Likely ones first; of equals the one that was found first.
  std::priority_queue<std::pair<std::pair<double, int>, int>> waiting_;
};

}  // namespace

PolicyGraph policy_graph(const ExactModel& model, const AlphaPolicy& policy, const WalkLimits& limits) {
  return Walk(model, policy, limits).run();
}

}  // namespace hypgen::exact
