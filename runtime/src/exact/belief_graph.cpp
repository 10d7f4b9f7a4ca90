// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/belief_graph.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace hypgen::exact {
namespace {

// A vector of a class with more states than this is computed for the belief's states alone, if they are few.
constexpr int kManyStates = 2048;
// Beliefs are the same node if all probabilities are equal in units of this; `SplitModel::rounding` covers
// it.
constexpr double kSame = 0x1p-50;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

std::int64_t rounded(double probability) { return std::llround(probability / kSame); }

std::uint64_t mixed(std::uint64_t hash, std::uint64_t value) {
  hash = (hash ^ value) * 0x9E3779B97F4A7C15u;
  return hash ^ (hash >> 29);
}

std::uint64_t hash_of(int of_class, const ClassBelief& belief) {
  std::uint64_t hash = mixed(0, static_cast<std::uint64_t>(of_class));
  for (std::size_t i = 0; i < belief.states.size(); ++i) {
    hash = mixed(hash, static_cast<std::uint64_t>(belief.states[i]));
    hash = mixed(hash, static_cast<std::uint64_t>(rounded(belief.probabilities[i])));
  }
  return hash;
}

bool same(const ClassBelief& a, const ClassBelief& b) {
  if (a.states != b.states) return false;
  for (std::size_t i = 0; i < a.states.size(); ++i) {
    if (rounded(a.probabilities[i]) != rounded(b.probabilities[i])) return false;
  }
  return true;
}

double expected(const std::vector<double>& values, const ClassBelief& belief) {
  double sum = 0.0;
  for (std::size_t i = 0; i < belief.states.size(); ++i) {
    sum += belief.probabilities[i] * values[index(belief.states[i])];
  }
  return sum;
}

}  // namespace

void BeliefGraph::add_class(AlphaVectors vectors, Sawtooth upper) {
  lower_.push_back(std::move(vectors));
  upper_.push_back(std::move(upper));
}

const AlphaVector* BeliefGraph::add(int of_class, AlphaVector vector) {
  vector.number = vectors_made_++;
  return lower_[index(of_class)].add(std::move(vector));
}

int BeliefGraph::node_of(int of_class, ClassBelief belief) {
  const std::uint64_t hash = hash_of(of_class, belief);
  const auto [begin, end] = by_belief_.equal_range(hash);
  for (auto it = begin; it != end; ++it) {
    const BeliefNode& node = nodes_[index(it->second)];
    if (node.of_class == of_class && same(node.belief, belief)) return it->second;
  }
  BeliefNode node;
  node.of_class = of_class;
  node.base = upper_[index(of_class)].base(belief);
  node.upper = Sawtooth::largest(node.base);
  node.lower = -model_.most();
  node.best = nullptr;
  node.belief = std::move(belief);
  node_bytes_ += sizeof(BeliefNode) + 48 + node.belief.states.size() * (sizeof(int) + sizeof(double)) +
                 node.base.size() * sizeof(double) + model_.actions(of_class).size() * sizeof(Choice);
  nodes_.push_back(std::move(node));
  by_belief_.emplace(hash, static_cast<int>(nodes_.size()) - 1);
  return static_cast<int>(nodes_.size()) - 1;
}

double BeliefGraph::lower(int at) {
  BeliefNode& node = nodes_[index(at)];
  lower_[index(node.of_class)].raise(node.belief, node.vectors_before, node.lower, node.best);
  node.vectors_before = vectors_made_;
  return node.lower;
}

double BeliefGraph::upper(int at) {
  BeliefNode& node = nodes_[index(at)];
  node.upper = upper_[index(node.of_class)].lowest(node.belief, node.base, node.points_before, node.upper);
  node.points_before = points_made_;
  return node.upper;
}

// The columns that the belief reaches, ascending, with their probabilities in `sums_`.
std::vector<int> BeliefGraph::columns_reached(const ClassAction& action, const BeliefNode& node) {
  if (sums_.size() < action.next.size()) sums_.resize(action.next.size(), 0.0);
  std::vector<int> reached;
  for (std::size_t i = 0; i < node.belief.states.size(); ++i) {
    const std::size_t state = index(node.belief.states[i]);
    for (int k = action.row_begin[state]; k < action.row_begin[state + 1]; ++k) {
      const double probability = node.belief.probabilities[i] * action.weight[index(k)];
      if (probability <= 0.0) continue;
      double& sum = sums_[index(action.column[index(k)])];
      if (sum == 0.0) reached.push_back(action.column[index(k)]);
      sum += probability;
    }
  }
  std::sort(reached.begin(), reached.end());
  return reached;
}

void BeliefGraph::expand(int at, int chosen) {
  const int of_class = nodes_[index(at)].of_class;
  const ClassAction& action = model_.actions(of_class)[index(chosen)];
  const std::vector<int> reached = columns_reached(action, nodes_[index(at)]);
  std::vector<Successor> successors;
  for (std::size_t i = 0; i < reached.size();) {
    const int outcome = action.outcome_of[index(reached[i])];
    const int next_class = action.outcomes[index(outcome)].next_class;
    ClassBelief next;
    double total = 0.0;
    for (; i < reached.size() && action.outcome_of[index(reached[i])] == outcome; ++i) {
      double& sum = sums_[index(reached[i])];
      next.states.push_back(action.next[index(reached[i])] - model_.first(next_class));
      next.probabilities.push_back(sum);
      total += sum;
      sum = 0.0;
    }
    for (double& probability : next.probabilities) probability /= total;
    successors.push_back({total, node_of(next_class, std::move(next)), outcome});
  }
  Choice& choice = nodes_[index(at)].choices[index(chosen)];
  node_bytes_ += successors.size() * sizeof(Successor);
  choice.successors = std::move(successors);
  choice.expanded = true;
  ++expansions_;
}

void BeliefGraph::look_at(int at, int chosen) {
  if (!nodes_[index(at)].choices[index(chosen)].expanded) expand(at, chosen);
  Choice& choice = nodes_[index(at)].choices[index(chosen)];
  double sum = 0.0;
  for (const Successor& successor : choice.successors) sum += successor.probability * upper(successor.node);
  choice.upper = std::min(choice.upper, choice.reward + model_.discount() * sum);
}

void BeliefGraph::make_choices(int at) {
  BeliefNode& node = nodes_[index(at)];
  if (!node.choices.empty()) return;
  for (const ClassAction& action : model_.actions(node.of_class)) {
    Choice& choice = node.choices.emplace_back();
    choice.upper = node.base[node.choices.size() - 1];
    choice.reward = expected(action.reward, node.belief);
  }
}

void BeliefGraph::open(int at) {
  make_choices(at);
  for (std::size_t a = 0; a < nodes_[index(at)].choices.size(); ++a) {
    if (!nodes_[index(at)].choices[a].expanded) expand(at, static_cast<int>(a));
  }
}

void BeliefGraph::lower_upper(int at, double value) {
  BeliefNode& node = nodes_[index(at)];
  if (value >= upper(at)) return;
  node.upper = value;
  upper_[index(node.of_class)].lower(node.belief, node.base, node.upper, points_made_++, node.point);
}

void BeliefGraph::lower_convex_bound(int of_class, const std::vector<double>& vectors) {
  upper_[index(of_class)].lower_convex(vectors);
}

void BeliefGraph::look_again() {
  for (BeliefNode& node : nodes_) {
    node.base = upper_[index(node.of_class)].base(node.belief);
    node.upper = std::min(node.upper, Sawtooth::largest(node.base));
    node.points_before = 0;
    for (std::size_t a = 0; a < node.choices.size(); ++a) {
      node.choices[a].upper = std::min(node.choices[a].upper, node.base[a]);
    }
  }
}

int BeliefGraph::best_choice(int at) {
  const auto& actions = model_.actions(nodes_[index(at)].of_class);
  make_choices(at);
  std::vector<char> fresh(actions.size(), 0);
  while (true) {
    const auto& choices = nodes_[index(at)].choices;
    const auto best = std::max_element(choices.begin(), choices.end(),
                                       [](const Choice& a, const Choice& b) { return a.upper < b.upper; });
    const auto chosen = static_cast<std::size_t>(best - choices.begin());
    if (choices.empty()) return -1;
    if (fresh[chosen] != 0) return static_cast<int>(chosen);
    look_at(at, static_cast<int>(chosen));
    fresh[chosen] = 1;
  }
}

std::vector<int> BeliefGraph::choices_by_upper(int at) {
  make_choices(at);
  const std::vector<Choice>& choices = nodes_[index(at)].choices;
  std::vector<int> order(choices.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return choices[index(a)].upper > choices[index(b)].upper; });
  return order;
}

double BeliefGraph::lower_by_successors(const Choice& choice) {
  double sum = 0.0;
  for (const Successor& successor : choice.successors) sum += successor.probability * lower(successor.node);
  return choice.reward + model_.discount() * sum;
}

double BeliefGraph::worst_after(int at, int chosen) const {
  const BeliefNode& node = nodes_[index(at)];
  const ClassAction& action = model_.actions(node.of_class)[index(chosen)];
  double sum = 0.0;
  for (std::size_t i = 0; i < node.belief.states.size(); ++i) {
    const std::size_t state = index(node.belief.states[i]);
    for (int k = action.row_begin[state]; k < action.row_begin[state + 1]; ++k) {
      const int column = action.column[index(k)];
      const int next_class = action.outcomes[index(action.outcome_of[index(column)])].next_class;
      const int next = action.next[index(column)] - model_.first(next_class);
      sum += node.belief.probabilities[i] * action.weight[index(k)] *
             lower_[index(next_class)].worst()[index(next)];
    }
  }
  return node.choices[index(chosen)].reward + model_.discount() * sum;
}

double BeliefGraph::choice_lower(int at, int chosen) {
  make_choices(at);
  double value = worst_after(at, chosen);
  const BeliefNode& node = nodes_[index(at)];
  const AlphaVectors& vectors = lower_[index(node.of_class)];
  for (const AlphaVector* vector : vectors.vectors()) {
    if (vector->choice == chosen) value = std::max(value, vectors.value(*vector, node.belief));
  }
  const Choice& choice = node.choices[index(chosen)];
  return choice.expanded ? std::max(value, lower_by_successors(choice)) : value;
}

// The expanded choice with the largest lower bound, among those that can be better than the node's.
int BeliefGraph::best_by_lower(int at, double& value) {
  int best = -1;
  const std::size_t choices = nodes_[index(at)].choices.size();
  for (std::size_t a = 0; a < choices; ++a) {
    const Choice& choice = nodes_[index(at)].choices[a];
    if (!choice.expanded || choice.upper <= value) continue;
    const double now = lower_by_successors(choice);
    if (now <= value) continue;
    value = now;
    best = static_cast<int>(a);
  }
  return best;
}

// The plan that takes the action and goes on with the best vector of each successor; after what the belief
// does not expect to see, with the usual one of the class.
AlphaVector BeliefGraph::vector_of(int at, int chosen) {
  const BeliefNode& node = nodes_[index(at)];
  const ClassAction& action = model_.actions(node.of_class)[index(chosen)];
  std::vector<const AlphaVector*> plan(action.outcomes.size(), nullptr);
  for (const Successor& successor : node.choices[index(chosen)].successors) {
    plan[index(successor.outcome)] = nodes_[index(successor.node)].best->current();
  }
  const int size = model_.size(node.of_class);
  AlphaVector vector;
  vector.choice = chosen;
  if (size > kManyStates && !model_.is_endless() && node.belief.states.size() < index(size) / 4)
    vector.states = node.belief.states;
  const std::size_t rows = vector.states.empty() ? index(size) : vector.states.size();
  for (std::size_t row = 0; row < rows; ++row) {
    const std::size_t state = vector.states.empty() ? row : index(vector.states[row]);
    double sum = 0.0;
    for (int k = action.row_begin[state]; k < action.row_begin[state + 1]; ++k) {
      const int column = action.column[index(k)];
      const int outcome = action.outcome_of[index(column)];
      const int next_class = action.outcomes[index(outcome)].next_class;
      const AlphaVector*& next = plan[index(outcome)];
      if (next == nullptr) next = lower_[index(next_class)].usual();
      const int next_state = action.next[index(column)] - model_.first(next_class);
      sum += action.weight[index(k)] * lower_[index(next_class)].value(*next, next_state);
    }
    vector.values.push_back(action.reward[state] + model_.discount() * sum);
  }
  vector.least = *std::min_element(vector.values.begin(), vector.values.end());
  for (const AlphaVector* next : plan) {
    if (next != nullptr) vector.least = std::min(vector.least, next->least);
  }
  if (!vector.states.empty()) vector.least = worst_;
  if (model_.closes_loops()) vector.plan = std::move(plan);
  return vector;
}

void BeliefGraph::back_up(int at, double nothing) {
  const int chosen = best_choice(at);
  if (chosen < 0) return;
  const double by_choice = nodes_[index(at)].choices[index(chosen)].upper;
  if (by_choice < upper(at) - nothing) {
    BeliefNode& node = nodes_[index(at)];
    node.upper = by_choice;
    upper_[index(node.of_class)].lower(node.belief, node.base, node.upper, points_made_++, node.point);
  }
  double value = lower(at) + nothing;
  const int best = best_by_lower(at, value);
  if (best < 0) return;
  const int of_class = nodes_[index(at)].of_class;
  add(of_class, vector_of(at, best));
  lower(at);
}

void BeliefGraph::clear() {
  nodes_.clear();
  by_belief_.clear();
  node_bytes_ = 0;
}

void BeliefGraph::prune_points() {
  for (Sawtooth& upper : upper_) upper.prune();
}

std::size_t BeliefGraph::points() const {
  std::size_t total = 0;
  for (const Sawtooth& upper : upper_) total += upper.points();
  return total;
}

std::size_t BeliefGraph::vectors() const {
  std::size_t total = 0;
  for (const AlphaVectors& lower : lower_) total += lower.vectors().size();
  return total;
}

std::size_t BeliefGraph::bound_bytes() const {
  std::size_t total = 0;
  for (const Sawtooth& upper : upper_) total += upper.bytes();
  for (const AlphaVectors& lower : lower_) total += lower.bytes();
  return total;
}

}  // namespace hypgen::exact
