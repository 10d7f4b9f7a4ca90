// SPDX-License-Identifier: Apache-2.0
// The upper half of refinement.hpp: which beliefs become points.
#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "point_process.hpp"

namespace hypgen::exact {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostPoints = 1500;  // that a refinement keeps
constexpr std::size_t kMostNew = 80;       // that it adds
constexpr std::size_t kMostFirst = 400;    // beliefs after a first step that are points from the start

std::size_t index(int i) { return static_cast<std::size_t>(i); }

// Each belief after a step is a mixture of what is believed after that step from its states, if these were
// known. With them as points no corner is needed.
void add_first_beliefs(const SplitModel& model, BeliefGraph& graph, UpperPoints& points) {
  std::set<int> found;
  for (int c = 0; c < model.classes(); ++c) {
    for (int s = 0; s < model.size(c); ++s) {
      const int node = graph.node_of(c, {{s}, {1.0}});
      graph.open(node);
      for (const Choice& choice : graph[node].choices) {
        for (const Successor& next : choice.successors) {
          const bool goes_on = !model.actions(graph[next.node].of_class).empty();
          if (goes_on && graph[next.node].belief.states.size() > 1) found.insert(next.node);
        }
      }
      if (found.size() > kMostFirst) return;
    }
  }
  for (const int node : points.nodes) found.erase(node);
  points.nodes.insert(points.nodes.end(), found.begin(), found.end());
}

}  // namespace

// The node's value after one more step, with mixtures for what follows.
double PointProcess::backed_up(int node) {
  graph_.open(node);
  double best = -kInfinity;
  for (std::size_t a = 0; a < graph_[node].choices.size(); ++a) {
    const std::size_t known = afters_.size();
    const Move move = move_of(node, static_cast<int>(a));
    for (std::size_t i = known; i < afters_.size(); ++i) {
      afters_[i].action = best_rest(afters_[i]).action;
      if (afters_[i].belief.states.size() > 1) mix(afters_[i], 0.0);
    }
    best = std::max(best, value(move));
  }
  return best;
}

// How far the parts of a mixture are from the belief: what a smooth value loses between them grows with it.
double PointProcess::spread(const After& after) const {
  double sum = 0.0;
  double square = 0.0;
  for (const double p : after.belief.probabilities) square += p * p;
  for (std::size_t i = 0; i < after.mixture.weights.size(); ++i) {
    const auto column = classes_[index(after.of_class)].priced.beliefs.col(after.mixture.points[i]);
    sum += after.mixture.weights[i] * column.squaredNorm();
  }
  for (const double mass : after.rest) sum += mass;
  return sum - square;
}

// The points that are met, and new ones.
void PointProcess::choose_points(const std::vector<int>& starts, const KeepGoing& keep_going) {
  std::vector<double> start(values_.size(), 0.0);
  for (const int node : starts) {
    const auto point = point_of_node_.find(node);
    if (point != point_of_node_.end()) start[index(point->second.first)] = 1.0;
  }
  const std::vector<double> visits = chain_visits(chain(), model_.discount(), start);
  if (visits.empty()) return keep_mixtures();
  std::vector<double> met(afters_.size(), 0.0);
  const auto meet = [&](std::size_t from, const Move& move) {
    for (const Branch& branch : move.branches) met[index(branch.after)] += visits[from] * branch.probability;
  };
  for (std::size_t p = 0; p < moves_.size(); ++p) meet(p, moves_[p][index(chosen_[p])]);
  for (std::size_t i = 0; i < convex_.size(); ++i) meet(moves_.size() + i, convex_[i]);
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < afters_.size(); ++i) {
    if (afters_[i].own >= 0 || afters_[i].belief.states.size() < 2 || met[i] <= 0.0) continue;
    order.emplace_back(-met[i] * spread(afters_[i]), i);
  }
  const std::size_t taken = std::min(order.size(), kMostNew);
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(taken), order.end());
  std::vector<std::pair<double, int>> kept;
  for (std::size_t p = 0; p < moves_.size(); ++p) kept.emplace_back(-visits[p], points_.nodes[p]);
  std::sort(kept.begin(), kept.end());
  std::vector<int> nodes;
  for (const auto& [visits_lost, node] : kept) {
    const bool is_start = std::find(starts.begin(), starts.end(), node) != starts.end();
    if (is_start || nodes.size() < kMostPoints) nodes.push_back(node);
  }
  price_points();
  for (std::size_t i = 0; i < taken && keep_going(); ++i) {
    const int node = afters_[order[i].second].node;
    const double before = value(afters_[order[i].second]);
    const double now = backed_up(node);
    if (now >= before) continue;
    graph_.lower_upper(node, now);
    nodes.push_back(node);
  }
  keep_mixtures();
  points_.nodes = std::move(nodes);
}

void refine_upper(const SplitModel& model, BeliefGraph& graph, const std::vector<int>& starts,
                  UpperPoints& points, const KeepGoing& keep_going) {
  // An ended episode is worth nothing more.
  points.nodes.erase(std::remove_if(points.nodes.begin(), points.nodes.end(),
                                    [&](int node) { return model.actions(graph[node].of_class).empty(); }),
                     points.nodes.end());
  if (points.mixtures.empty()) add_first_beliefs(model, graph, points);
  PointProcess process(model, graph, points);
  process.gather();
  const bool is_solved = process.solve(keep_going);
  process.give_back();
  if (is_solved) process.choose_points(starts, keep_going);
}

}  // namespace hypgen::exact
