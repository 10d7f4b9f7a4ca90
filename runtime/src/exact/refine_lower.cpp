// SPDX-License-Identifier: Apache-2.0
// The lower half of refinement.hpp: vectors as a controller.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <set>
#include <utility>

#include "hypgen/exact/chain.hpp"
#include "hypgen/exact/refinement.hpp"

namespace hypgen::exact {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostFollowed = 200;
constexpr std::size_t kMostUnknowns = 1200;  // values of a controller's vectors
constexpr int kMostRounds = 30;
// Another round is worth it if the last raised the values at the start by more than this part.
constexpr double kNothing = 1e-6;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

// Vectors and the vectors that follow them. A vector gives way to one that is nowhere less, so what followed it
// may lead back to it.
class Controller {
 public:
  Controller(const SplitModel& model, BeliefGraph& graph) : model_(model), graph_(graph) {}

  void gather(const std::vector<int>& points);
  void add_vectors();

 private:
  struct Step {
    int of_class;
    const AlphaVector* vector;
    std::size_t begin;  // of its unknowns: a value for each state of the class
  };

  void take(int of_class, const AlphaVector* vector);
  int stands_for(int of_class, const AlphaVector* vector);

  const SplitModel& model_;
  BeliefGraph& graph_;
  std::vector<Step> steps_;
  std::map<const AlphaVector*, std::size_t> begin_;
  std::size_t unknowns_ = 0;
};

void Controller::take(int of_class, const AlphaVector* vector) {
  const std::size_t size = index(model_.size(of_class));
  if (vector->plan.empty() || unknowns_ + size > kMostUnknowns) return;
  if (!begin_.emplace(vector, unknowns_).second) return;
  steps_.push_back({of_class, vector, unknowns_});
  unknowns_ += size;
}

// Those that are best somewhere come first; what there is no room for stays what it is worth.
void Controller::gather(const std::vector<int>& points) {
  for (const int point : points) {
    graph_.lower(point);
    take(graph_[point].of_class, graph_[point].best->current());
  }
  for (int c = 0; c < model_.classes(); ++c) {
    for (const AlphaVector* vector : graph_.lower_bounds()[index(c)].vectors()) take(c, vector);
  }
}

// Where the vector's unknowns begin. There is no room for all: those of the vector that is nowhere far below it
// stand for the others. So a loop is one of the controller's own, and its worth that of very many steps. -1
// where the controller has no vector of the class: what follows is worth what is known of it.
int Controller::stands_for(int of_class, const AlphaVector* vector) {
  const auto known = begin_.find(vector);
  if (known != begin_.end()) return static_cast<int>(known->second);
  double least_loss = kInfinity;
  const Step* found = nullptr;
  for (const Step& step : steps_) {
    if (step.of_class != of_class) continue;
    double loss = -kInfinity;
    for (std::size_t s = 0; s < vector->values.size(); ++s) {
      loss = std::max(loss, vector->values[s] - step.vector->values[s]);
    }
    if (found != nullptr && loss >= least_loss) continue;
    least_loss = loss;
    found = &step;
  }
  if (found == nullptr) return -1;
  begin_.emplace(vector, found->begin);
  return static_cast<int>(found->begin);
}

void Controller::add_vectors() {
  Chain chain;
  chain.reward.assign(unknowns_, 0.0);
  double least = 0.0;
  for (const Step& step : steps_) {
    const ClassAction& action = model_.actions(step.of_class)[index(step.vector->choice)];
    for (std::size_t s = 0; s < index(model_.size(step.of_class)); ++s) {
      const std::size_t from = step.begin + s;
      chain.reward[from] = action.reward[s];
      for (int i = action.row_begin[s]; i < action.row_begin[s + 1]; ++i) {
        const int column = action.column[index(i)];
        const int outcome = action.outcome_of[index(column)];
        const int next_class = action.outcomes[index(outcome)].next_class;
        const int next = action.next[index(column)] - model_.first(next_class);
        const AlphaVector* after = step.vector->plan[index(outcome)]->current();
        const int begin = stands_for(next_class, after);
        if (begin >= 0) {
          chain.lead(static_cast<int>(from), begin + next, action.weight[index(i)]);
        } else {
          least = std::min(least, after->least);
          chain.reward[from] += model_.discount() * action.weight[index(i)] * after->values[index(next)];
        }
      }
    }
  }
  if (model_.is_endless() && !ends_always(chain)) return;
  std::vector<double> values = chain_values(chain, model_.discount());
  if (values.empty()) return;
  std::vector<double> once = chain.reward;
  for (const Chain::Entry& entry : chain.entries) {
    once[index(entry.row())] += model_.discount() * entry.value() * values[index(entry.col())];
  }
  double high = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) high = std::max(high, values[i] - once[i]);
  const double steps = model_.is_endless() ? most_steps(chain) : model_.steps();
  for (double& value : values) {
    value -= high * steps;
    least = std::min(least, value);
  }
  // All are made before one is added, as a vector that gives way to another loses its plan. All are added, as
  // a policy takes the best vector of each belief: where it goes on, there is one of at least the same worth.
  std::vector<AlphaVector> vectors;
  for (const Step& step : steps_) {
    const auto from = values.begin() + static_cast<std::ptrdiff_t>(step.begin);
    AlphaVector vector;
    vector.choice = step.vector->choice;
    vector.values.assign(from, from + model_.size(step.of_class));
    vector.plan = step.vector->plan;
    vector.least = least;
    vectors.push_back(std::move(vector));
  }
  for (std::size_t i = 0; i < steps_.size(); ++i) graph_.add(steps_[i].of_class, std::move(vectors[i]));
}

// Beliefs that the policy of the best vectors meets, the likeliest first.
std::vector<int> followed(const SplitModel& model, BeliefGraph& graph, const std::vector<int>& starts) {
  std::priority_queue<std::pair<double, int>> waiting;
  for (const int start : starts) waiting.emplace(1.0, start);
  std::vector<int> points;
  std::set<int> met;
  while (!waiting.empty() && points.size() < kMostFollowed) {
    const auto [reach, node] = waiting.top();
    waiting.pop();
    if (!met.insert(node).second) continue;
    points.push_back(node);
    graph.open(node);
    double best = -kInfinity;
    std::size_t chosen = 0;
    for (std::size_t a = 0; a < graph[node].choices.size(); ++a) {
      double sum = 0.0;
      for (const Successor& next : graph[node].choices[a].successors) {
        sum += next.probability * graph.lower(next.node);
      }
      const double now = graph[node].choices[a].reward + model.discount() * sum;
      if (now > best) chosen = a;
      best = std::max(best, now);
    }
    if (graph[node].choices.empty()) continue;
    for (const Successor& next : graph[node].choices[chosen].successors) {
      waiting.emplace(reach * next.probability, next.node);
    }
  }
  return points;
}

}  // namespace

void refine_lower(const SplitModel& model, BeliefGraph& graph, const std::vector<int>& starts,
                  const std::vector<int>& upper_points, const KeepGoing& keep_going) {
  double before = -kInfinity;
  for (int round = 0; round < kMostRounds; ++round) {
    std::vector<int> points = followed(model, graph, starts);
    points.insert(points.end(), upper_points.begin(), upper_points.end());
    for (auto node = points.rbegin(); node != points.rend(); ++node) {
      if (!keep_going()) return;
      graph.back_up(*node, 0.0);
    }
    Controller controller(model, graph);
    controller.gather(points);
    controller.add_vectors();
    double now = 0.0;
    for (const int start : starts) now += graph.lower(start);
    if (now - before <= kNothing * std::abs(now)) return;
    before = now;
  }
}

}  // namespace hypgen::exact
