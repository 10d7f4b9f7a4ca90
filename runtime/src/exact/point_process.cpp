// SPDX-License-Identifier: Apache-2.0
#include "point_process.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace hypgen::exact {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMostRounds = 30;
constexpr int kMostTries = 3;
// A mixture without corners leaves less.
constexpr double kWhole = 1e-9;
// A choice is better if it is by more than this part of the largest value, a mixture by this part of it.
constexpr double kBetter = 1e-12;
constexpr double kCheaper = 1e-9;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

}  // namespace

std::size_t PointProcess::unknown(int of_class, int state, std::size_t action) const {
  return convex_begin_[index(of_class)] + index(state) * model_.actions(of_class).size() + action;
}

int PointProcess::point_of(const After& after, std::size_t part) const {
  return classes_[index(after.of_class)].points[index(after.mixture.points[part])];
}

// Begins with the mixture of the last time, as far as its points are still there.
int PointProcess::after_of(int node) {
  const auto [found, is_new] = after_of_node_.emplace(node, static_cast<int>(afters_.size()));
  if (!is_new) return found->second;
  After after{node, graph_[node].of_class, graph_[node].belief};
  const auto own = point_of_node_.find(node);
  if (own != point_of_node_.end()) after.own = own->second.first;
  const auto before = points_.mixtures.find(node);
  if (before != points_.mixtures.end()) {
    after.mixture = before->second;
    for (int& point : after.mixture.points) {
      const auto now = point_of_node_.find(point);
      point = now == point_of_node_.end() ? -1 : now->second.second;
    }
    const std::vector<int>& points = after.mixture.points;
    if (std::find(points.begin(), points.end(), -1) != points.end()) after.mixture = {};
  }
  after.cheapest = after.mixture;
  leave_rest(after);
  afters_.push_back(std::move(after));
  return found->second;
}

// What the mixture leaves.
void PointProcess::leave_rest(After& after) const {
  after.rest = after.belief.probabilities;
  for (std::size_t i = 0; i < after.mixture.points.size(); ++i) {
    const auto column = classes_[index(after.of_class)].priced.beliefs.col(after.mixture.points[i]);
    for (std::size_t s = 0; s < after.rest.size(); ++s) {
      after.rest[s] -= after.mixture.weights[i] * column[after.belief.states[s]];
    }
  }
  for (double& mass : after.rest) mass = std::max(mass, 0.0);
}

PointProcess::Move PointProcess::move_of(int node, int choice) {
  const Choice& from = graph_[node].choices[index(choice)];
  Move move{from.reward, {}};
  for (const Successor& successor : from.successors) {
    if (model_.actions(graph_[successor.node].of_class).empty()) continue;  // is worth nothing
    move.branches.push_back({successor.probability, after_of(successor.node)});
  }
  return move;
}

void PointProcess::gather() {
  classes_.resize(index(model_.classes()));
  for (std::size_t p = 0; p < points_.nodes.size(); ++p) {
    const int node = points_.nodes[p];
    std::vector<int>& of_class = classes_[index(graph_[node].of_class)].points;
    point_of_node_[node] = {static_cast<int>(p), static_cast<int>(of_class.size())};
    of_class.push_back(static_cast<int>(p));
    values_.push_back(graph_.upper(node));
  }
  std::size_t unknowns = values_.size();
  for (int c = 0; c < model_.classes(); ++c) {
    convex_begin_.push_back(unknowns);
    unknowns += index(model_.size(c)) * model_.actions(c).size();
    const std::vector<double>& vectors = graph_.convex_bound(c);
    values_.insert(values_.end(), vectors.begin(), vectors.end());
    ClassPoints& of_class = classes_[index(c)];
    of_class.priced.beliefs.setZero(model_.size(c), static_cast<Eigen::Index>(of_class.points.size()));
    for (std::size_t i = 0; i < of_class.points.size(); ++i) {
      const ClassBelief& belief = graph_[points_.nodes[index(of_class.points[i])]].belief;
      for (std::size_t s = 0; s < belief.states.size(); ++s) {
        of_class.priced.beliefs(belief.states[s], static_cast<Eigen::Index>(i)) = belief.probabilities[s];
      }
    }
  }
  for (const int node : points_.nodes) {
    graph_.open(node);
    moves_.emplace_back();
    for (std::size_t a = 0; a < graph_[node].choices.size(); ++a) {
      moves_.back().push_back(move_of(node, static_cast<int>(a)));
    }
    chosen_.push_back(0);
  }
  for (int c = 0; c < model_.classes(); ++c) {
    for (int s = 0; s < model_.size(c); ++s) {
      const int node = graph_.node_of(c, {{s}, {1.0}});
      graph_.open(node);
      for (std::size_t a = 0; a < model_.actions(c).size(); ++a) {
        convex_.push_back(move_of(node, static_cast<int>(a)));
      }
    }
  }
}

double PointProcess::value_of_rest(const After& after, std::size_t action) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < after.rest.size(); ++i) {
    sum += after.rest[i] * values_[unknown(after.of_class, after.belief.states[i], action)];
  }
  return sum;
}

// The convex bound of what the mixture leaves.
PointProcess::Rest PointProcess::best_rest(const After& after) const {
  Rest best{-kInfinity, 0};
  for (std::size_t a = 0; a < model_.actions(after.of_class).size(); ++a) {
    const double now = value_of_rest(after, a);
    if (now > best.value) best = {now, static_cast<int>(a)};
  }
  return best;
}

double PointProcess::value(const After& after) const {
  if (after.own >= 0) return values_[index(after.own)];
  double sum = value_of_rest(after, index(after.action));
  for (std::size_t i = 0; i < after.mixture.weights.size(); ++i) {
    sum += after.mixture.weights[i] * values_[index(point_of(after, i))];
  }
  return sum;
}

double PointProcess::value(const Move& move) const {
  double sum = 0.0;
  for (const Branch& branch : move.branches) sum += branch.probability * value(afters_[index(branch.after)]);
  return move.reward + model_.discount() * sum;
}

// What the agent does; false if nothing is better.
bool PointProcess::improve_actions() {
  const double enough = kBetter * largest(values_);
  bool changed = false;
  for (After& after : afters_) {
    if (after.own >= 0) continue;
    const Rest best = best_rest(after);
    if (best.value <= value_of_rest(after, index(after.action)) + enough) continue;
    after.action = best.action;
    changed = true;
  }
  for (std::size_t p = 0; p < moves_.size(); ++p) {
    double best = value(moves_[p][index(chosen_[p])]);
    for (std::size_t a = 0; a < moves_[p].size(); ++a) {
      const double now = value(moves_[p][a]);
      if (now <= best + enough) continue;
      best = now;
      chosen_[p] = static_cast<int>(a);
      changed = true;
    }
  }
  return changed;
}

void PointProcess::price_points() {
  for (ClassPoints& of_class : classes_) {
    of_class.priced.costs.resize(static_cast<Eigen::Index>(of_class.points.size()));
    for (std::size_t i = 0; i < of_class.points.size(); ++i) {
      of_class.priced.costs[static_cast<Eigen::Index>(i)] = values_[index(of_class.points[i])];
    }
  }
}

// Bounds the belief by a cheaper mixture; false if there is none. A rest is worth the convex bound's vector of
// one action. So corners cost at first what their best vectors say, which is enough for any rest, and then what
// the vector says that is best for the rest that was found.
bool PointProcess::mix(After& after, double enough) {
  const PricedPoints& points = classes_[index(after.of_class)].priced;
  bool changed = false;
  for (int tries = 0; tries < kMostTries; ++tries) {
    After next = after;
    std::vector<double> corners;
    for (const int state : after.belief.states) {
      const auto first = values_.begin() + static_cast<std::ptrdiff_t>(unknown(after.of_class, state, 0));
      const auto width = static_cast<std::ptrdiff_t>(model_.actions(after.of_class).size());
      corners.push_back(tries == 0 ? *std::max_element(first, first + width) : first[after.action]);
    }
    next.mixture =
        cheapest_mixture(points, after.belief, corners, tries == 0 ? after.cheapest : after.mixture);
    if (tries == 0) after.cheapest = next.mixture;
    leave_rest(next);
    next.action = best_rest(next).action;
    const bool is_better = value(next) < value(after) - enough;
    if (is_better) {
      next.cheapest = after.cheapest;
      after = std::move(next);
      changed = true;
    }
    const bool is_whole = std::accumulate(after.rest.begin(), after.rest.end(), 0.0) < kWhole;
    if (is_whole || (tries > 0 && !is_better)) break;
  }
  return changed;
}

// Which points bound the beliefs that are met; false if none bounds one better.
bool PointProcess::improve_mixtures() {
  const double enough = kCheaper * largest(values_);
  price_points();
  std::vector<char> is_met(afters_.size(), 0);
  const auto meet = [&](const Move& move) {
    for (const Branch& branch : move.branches) is_met[index(branch.after)] = 1;
  };
  for (std::size_t p = 0; p < moves_.size(); ++p) meet(moves_[p][index(chosen_[p])]);
  for (const Move& move : convex_) meet(move);
  bool changed = false;
  for (std::size_t i = 0; i < afters_.size(); ++i) {
    After& after = afters_[i];
    if (is_met[i] == 0 || after.own >= 0 || after.belief.states.size() < 2) continue;
    changed = mix(after, enough) || changed;
  }
  return changed;
}

void PointProcess::lead(Chain& chain, int from, const Move& move) const {
  for (const Branch& branch : move.branches) {
    const After& after = afters_[index(branch.after)];
    if (after.own >= 0) {
      chain.lead(from, after.own, branch.probability);
      continue;
    }
    for (std::size_t i = 0; i < after.mixture.weights.size(); ++i) {
      chain.lead(from, point_of(after, i), branch.probability * after.mixture.weights[i]);
    }
    for (std::size_t i = 0; i < after.rest.size(); ++i) {
      const std::size_t to = unknown(after.of_class, after.belief.states[i], index(after.action));
      chain.lead(from, static_cast<int>(to), branch.probability * after.rest[i]);
    }
  }
}

Chain PointProcess::chain() const {
  Chain chain;
  for (std::size_t p = 0; p < moves_.size(); ++p) {
    const Move& move = moves_[p][index(chosen_[p])];
    chain.reward.push_back(move.reward);
    lead(chain, static_cast<int>(p), move);
  }
  for (const Move& move : convex_) {
    lead(chain, static_cast<int>(chain.reward.size()), move);
    chain.reward.push_back(move.reward);
  }
  return chain;
}

bool PointProcess::evaluate() {
  const Chain chain = this->chain();
  if (model_.is_endless() && !ends_always(chain)) return false;
  std::vector<double> values = chain_values(chain, model_.discount());
  if (values.empty()) return false;
  values_ = std::move(values);
  return true;
}

bool PointProcess::solve(const KeepGoing& keep_going) {
  const std::vector<double> before = values_;
  for (After& after : afters_) {
    if (after.own < 0) after.action = best_rest(after).action;
  }
  for (int round = 0; round < kMostRounds; ++round) {
    for (int inner = 0; inner < kMostRounds && (improve_actions() || inner == 0); ++inner) {
      if (!keep_going() || !evaluate()) {
        values_ = before;
        return false;
      }
    }
    if (!improve_mixtures()) break;
  }
  // One more sweep shows by how much a value may be too low, for each step.
  double low = 0.0;
  for (After& after : afters_) {
    if (after.own < 0) after.action = best_rest(after).action;
  }
  for (std::size_t p = 0; p < moves_.size(); ++p) {
    for (const Move& move : moves_[p]) low = std::max(low, value(move) - values_[p]);
  }
  for (std::size_t i = 0; i < convex_.size(); ++i) {
    low = std::max(low, value(convex_[i]) - values_[moves_.size() + i]);
  }
  for (double& value : values_) value += low * model_.steps();
  return true;
}

void PointProcess::give_back() {
  for (int c = 0; c < model_.classes(); ++c) {
    const auto from = values_.begin() + static_cast<std::ptrdiff_t>(convex_begin_[index(c)]);
    const std::size_t size = index(model_.size(c)) * model_.actions(c).size();
    graph_.lower_convex_bound(c, std::vector<double>(from, from + static_cast<std::ptrdiff_t>(size)));
  }
  graph_.look_again();
  for (std::size_t p = 0; p < moves_.size(); ++p) graph_.lower_upper(points_.nodes[p], values_[p]);
}

void PointProcess::keep_mixtures() {
  points_.mixtures.clear();
  for (const After& after : afters_) {
    if (after.mixture.points.empty()) continue;
    Mixture& kept = points_.mixtures[after.node];
    kept = after.mixture;
    for (std::size_t i = 0; i < kept.points.size(); ++i)
      kept.points[i] = points_.nodes[index(point_of(after, i))];
  }
}

}  // namespace hypgen::exact
