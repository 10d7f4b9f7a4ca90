// SPDX-License-Identifier: Apache-2.0
// The upper half of refinement.hpp: points and the convex bound as a decision process.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "hypgen/exact/chain.hpp"
#include "hypgen/exact/refinement.hpp"

namespace hypgen::exact {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostPoints = 1500;
// Beliefs of each refinement that are looked at, and that become points.
constexpr std::size_t kMostLooked = 300;
constexpr std::size_t kMostNew = 80;
constexpr int kMostRounds = 30;
// A choice is better if it is by more than this part of the largest value.
constexpr double kBetter = 1e-12;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

// The upper bound as a decision process. Its unknowns are the values of the points and, of each state and
// action, those of the convex bound. What follows an action is a point, or a share of one and a rest of which
// the convex bound is taken, with one action for all of its states.
class PointProcess {
 public:
  PointProcess(const SplitModel& model, BeliefGraph& graph) : model_(model), graph_(graph) {}

  void gather(const std::vector<int>& points);
  void solve(const KeepGoing& keep_going);
  void give_back();
  std::vector<int> next_points(const std::vector<int>& starts);

 private:
  struct Point {
    int of_class;
    ClassBelief belief;
    std::vector<double> scattered;  // over the class's states
  };
  struct Branch {
    double probability;
    int after;
  };
  struct Move {
    double reward;
    std::vector<Branch> branches;
  };
  // A belief that follows.
  struct After {
    int node;
    int of_class;
    ClassBelief belief;
    int own = -1;    // the point that it is
    int point = -1;  // the point of which it has a share
    double share = 0.0;
    int action = 0;                                // for the rest
    std::vector<std::pair<int, double>> shares{};  // of all points that it has a share of
  };

  int after_of(int node);
  Move move_of(int node, int choice);
  std::size_t unknown(int of_class, int state, std::size_t action) const {
    return convex_begin_[index(of_class)] + index(state) * model_.actions(of_class).size() + action;
  }
  double rest(const After& after, int point, double share, std::size_t action) const;
  std::pair<double, int> best_rest(const After& after, int point, double share) const;
  double value(const After& after) const;
  double value(const Move& move) const;
  bool improve_actions();
  bool improve_shares();
  bool evaluate();
  Chain chain() const;
  double backed_up(int node);
  void lead(Chain& chain, int from, const Move& move) const;

  const SplitModel& model_;
  BeliefGraph& graph_;
  std::vector<int> nodes_;  // of the points
  std::vector<Point> points_;
  std::vector<std::vector<Move>> moves_;  // of each point
  std::vector<int> chosen_;               // of each point's moves
  std::vector<std::size_t> convex_begin_;
  std::vector<Move> convex_;  // of each state and action, behind the points
  std::vector<After> afters_;
  std::map<int, int> after_of_node_;
  std::map<int, int> point_of_node_;
  std::vector<double> values_;
};

int PointProcess::after_of(int node) {
  const auto [found, is_new] = after_of_node_.emplace(node, static_cast<int>(afters_.size()));
  if (!is_new) return found->second;
  After after{node, graph_[node].of_class, graph_[node].belief};
  const auto own = point_of_node_.find(node);
  if (own != point_of_node_.end()) after.own = own->second;
  std::vector<double> here(index(model_.size(after.of_class)), 0.0);
  for (std::size_t i = 0; i < after.belief.states.size(); ++i) {
    here[index(after.belief.states[i])] = after.belief.probabilities[i];
  }
  for (std::size_t p = 0; p < points_.size() && after.own < 0; ++p) {
    if (points_[p].of_class != after.of_class) continue;
    double share = 1.0;
    const ClassBelief& belief = points_[p].belief;
    for (std::size_t i = 0; i < belief.states.size() && share > 0.0; ++i) {
      share = std::min(share, here[index(belief.states[i])] / belief.probabilities[i]);
    }
    if (share > 1e-9) after.shares.emplace_back(static_cast<int>(p), share);
  }
  afters_.push_back(std::move(after));
  return static_cast<int>(afters_.size()) - 1;
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

void PointProcess::gather(const std::vector<int>& points) {
  nodes_ = points;
  for (const int node : nodes_) {
    const int of_class = graph_[node].of_class;
    point_of_node_.emplace(node, static_cast<int>(points_.size()));
    Point point{of_class, graph_[node].belief, std::vector<double>(index(model_.size(of_class)), 0.0)};
    for (std::size_t i = 0; i < point.belief.states.size(); ++i) {
      point.scattered[index(point.belief.states[i])] = point.belief.probabilities[i];
    }
    points_.push_back(std::move(point));
    values_.push_back(graph_.upper(node));
  }
  std::size_t unknowns = points_.size();
  for (int c = 0; c < model_.classes(); ++c) {
    convex_begin_.push_back(unknowns);
    unknowns += index(model_.size(c)) * model_.actions(c).size();
    const std::vector<double>& vectors = graph_.convex_bound(c);
    values_.insert(values_.end(), vectors.begin(), vectors.end());
  }
  for (const int node : nodes_) {
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

// The convex bound of what is left of a belief without the share, for one action.
double PointProcess::rest(const After& after, int point, double share, std::size_t action) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < after.belief.states.size(); ++i) {
    const int state = after.belief.states[i];
    double mass = after.belief.probabilities[i];
    if (point >= 0) mass = std::max(0.0, mass - share * points_[index(point)].scattered[index(state)]);
    sum += mass * values_[unknown(after.of_class, state, action)];
  }
  return sum;
}

std::pair<double, int> PointProcess::best_rest(const After& after, int point, double share) const {
  double best = -kInfinity;
  int action = 0;
  for (std::size_t a = 0; a < model_.actions(after.of_class).size(); ++a) {
    const double now = rest(after, point, share, a);
    if (now > best) action = static_cast<int>(a);
    best = std::max(best, now);
  }
  return {best, action};
}

double PointProcess::value(const After& after) const {
  if (after.own >= 0) return values_[index(after.own)];
  const double of_point = after.point < 0 ? 0.0 : after.share * values_[index(after.point)];
  return of_point + rest(after, after.point, after.share, index(after.action));
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
    const double now = rest(after, after.point, after.share, index(after.action));
    const auto [best, action] = best_rest(after, after.point, after.share);
    if (best <= now + enough) continue;
    after.action = action;
    changed = true;
  }
  for (std::size_t p = 0; p < points_.size(); ++p) {
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

// Which points bound a belief; false if none bounds it better.
bool PointProcess::improve_shares() {
  const double enough = 1e-9 * largest(values_);
  bool changed = false;
  std::vector<double> drops;  // of the points below the convex bound
  for (std::size_t p = 0; p < points_.size(); ++p) {
    const After whole{-1, points_[p].of_class, points_[p].belief};
    drops.push_back(best_rest(whole, -1, 0.0).first - values_[p]);
  }
  for (After& after : afters_) {
    if (after.own >= 0) continue;
    double best = value(after);
    const double convex = best_rest(after, -1, 0.0).first;
    for (const auto& [point, share] : after.shares) {
      // The rest's convex bound is at least what is left of the whole's.
      if (convex - share * drops[index(point)] >= best - enough) continue;
      const auto [rest, action] = best_rest(after, point, share);
      const double now = share * values_[index(point)] + rest;
      if (now >= best - enough) continue;
      best = now;
      after.point = point;
      after.share = share;
      after.action = action;
      changed = true;
    }
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
    if (after.point >= 0) chain.lead(from, after.point, branch.probability * after.share);
    for (std::size_t i = 0; i < after.belief.states.size(); ++i) {
      const int state = after.belief.states[i];
      double mass = after.belief.probabilities[i];
      if (after.point >= 0) {
        mass = std::max(0.0, mass - after.share * points_[index(after.point)].scattered[index(state)]);
      }
      chain.lead(from, static_cast<int>(unknown(after.of_class, state, index(after.action))),
                 branch.probability * mass);
    }
  }
}

Chain PointProcess::chain() const {
  Chain chain;
  for (std::size_t p = 0; p < points_.size(); ++p) {
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

void PointProcess::solve(const KeepGoing& keep_going) {
  const std::vector<double> before = values_;
  improve_shares();
  for (int round = 0; round < kMostRounds; ++round) {
    for (int inner = 0; inner < kMostRounds && (improve_actions() || inner == 0); ++inner) {
      if (!keep_going() || !evaluate()) {
        values_ = before;
        return;
      }
    }
    if (!improve_shares()) break;
  }
  // One more sweep shows by how much a value may be too low, for each step.
  double low = 0.0;
  for (After& after : afters_) {
    if (after.own < 0) after.action = best_rest(after, after.point, after.share).second;
  }
  for (std::size_t p = 0; p < points_.size(); ++p) {
    for (const Move& move : moves_[p]) low = std::max(low, value(move) - values_[p]);
  }
  for (std::size_t i = 0; i < convex_.size(); ++i) {
    low = std::max(low, value(convex_[i]) - values_[points_.size() + i]);
  }
  for (double& value : values_) value += low * model_.steps();
}

void PointProcess::give_back() {
  for (int c = 0; c < model_.classes(); ++c) {
    const auto from = values_.begin() + static_cast<std::ptrdiff_t>(convex_begin_[index(c)]);
    const std::size_t size = index(model_.size(c)) * model_.actions(c).size();
    graph_.lower_convex_bound(c, std::vector<double>(from, from + static_cast<std::ptrdiff_t>(size)));
  }
  graph_.look_again();
  for (std::size_t p = 0; p < points_.size(); ++p) graph_.lower_upper(nodes_[p], values_[p]);
}

// The node's value after one more step, with what follows bounded as it is now.
double PointProcess::backed_up(int node) {
  graph_.open(node);
  double best = -kInfinity;
  for (std::size_t a = 0; a < graph_[node].choices.size(); ++a) {
    const Choice choice = graph_[node].choices[a];
    double sum = 0.0;
    for (const Successor& successor : choice.successors) {
      sum += successor.probability * graph_.upper(successor.node);
    }
    best = std::max(best, choice.reward + model_.discount() * sum);
  }
  return best;
}

// The points that are met, and new ones.
std::vector<int> PointProcess::next_points(const std::vector<int>& starts) {
  std::vector<double> start(values_.size(), 0.0);
  for (const int node : starts) {
    const auto point = point_of_node_.find(node);
    if (point != point_of_node_.end()) start[index(point->second)] = 1.0;
  }
  const std::vector<double> visits = chain_visits(chain(), model_.discount(), start);
  if (visits.empty()) return nodes_;
  std::vector<double> met(afters_.size(), 0.0);
  const auto meet = [&](std::size_t from, const Move& move) {
    for (const Branch& branch : move.branches) met[index(branch.after)] += visits[from] * branch.probability;
  };
  for (std::size_t p = 0; p < points_.size(); ++p) meet(p, moves_[p][index(chosen_[p])]);
  for (std::size_t i = 0; i < convex_.size(); ++i) meet(points_.size() + i, convex_[i]);
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < afters_.size(); ++i) {
    if (afters_[i].own < 0 && afters_[i].belief.states.size() > 1 && met[i] > 0.0) order.push_back(i);
  }
  const std::size_t looked = std::min(order.size(), kMostLooked);
  // What a belief loses grows with the part of it that no point bounds.
  const auto loss = [&](std::size_t i) { return met[i] * (1.0 - afters_[i].share); };
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(looked), order.end(),
                    [&](std::size_t a, std::size_t b) { return loss(a) > loss(b); });
  std::vector<std::pair<double, int>> gains;
  std::vector<double> lower(looked);
  for (std::size_t i = 0; i < looked; ++i) {
    const int node = afters_[order[i]].node;
    lower[i] = backed_up(node);
    gains.emplace_back(-met[order[i]] * (value(afters_[order[i]]) - lower[i]), static_cast<int>(i));
  }
  std::sort(gains.begin(), gains.end());
  std::vector<int> points;
  std::vector<std::pair<double, int>> kept;
  for (std::size_t p = 0; p < points_.size(); ++p) kept.emplace_back(-visits[p], nodes_[p]);
  std::sort(kept.begin(), kept.end());
  for (const auto& [visits_lost, node] : kept) {
    const bool is_start = std::find(starts.begin(), starts.end(), node) != starts.end();
    if (is_start || points.size() < kMostPoints) points.push_back(node);
  }
  for (std::size_t i = 0; i < std::min(kMostNew, gains.size()) && gains[i].first < 0.0; ++i) {
    const auto at = index(gains[i].second);
    graph_.lower_upper(afters_[order[at]].node, lower[at]);
    points.push_back(afters_[order[at]].node);
  }
  return points;
}

}  // namespace

void refine_upper(const SplitModel& model, BeliefGraph& graph, const std::vector<int>& starts,
                  std::vector<int>& points, const KeepGoing& keep_going) {
  PointProcess process(model, graph);
  process.gather(points);
  process.solve(keep_going);
  process.give_back();
  points = process.next_points(starts);
}

}  // namespace hypgen::exact
