// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/long_run.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "hypgen/exact/chain.hpp"

namespace hypgen::exact {
namespace {

// Factors of larger systems take too much time and memory.
constexpr int kMostStates = 20000;
constexpr std::size_t kMostInformed = 3000;
constexpr int kMostImprovements = 200;
// An action is better if it is by more than this part of the largest value.
constexpr double kBetter = 1e-13;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

// Calls `visit(state of the model, class, state of the class)` for each state.
template <class Visit>
void for_states(const SplitModel& model, Visit visit) {
  for (int c = 0; c < model.classes(); ++c) {
    for (int s = 0; s < model.size(c); ++s) visit(model.first(c) + s, c, index(s));
  }
}

// Calls `visit(next state, weight)` for each entry of the action's row.
template <class Visit>
void for_successors(const ClassAction& action, std::size_t state, Visit visit) {
  for (int i = action.row_begin[state]; i < action.row_begin[state + 1]; ++i) {
    visit(action.next[index(action.column[index(i)])], action.weight[index(i)]);
  }
}

double worth(const SplitModel& model, const ClassAction& action, std::size_t state,
             const StateValues& values) {
  double sum = 0.0;
  for_successors(action, state, [&](int next, double weight) { sum += weight * values[index(next)]; });
  return action.reward[state] + model.discount() * sum;
}

// Adds the action's row to a chain over states.
void add_row(const SplitModel& model, const ClassAction& action, int of_class, std::size_t state,
             double share, Chain& chain) {
  const int from = model.first(of_class) + static_cast<int>(state);
  chain.reward[index(from)] += share * action.reward[state];
  for_successors(action, state, [&](int next, double weight) { chain.lead(from, next, share * weight); });
}

StateValues values_of(const SplitModel& model, const Chain& chain) {
  if (model.is_endless() && !ends_always(chain)) return {};
  return chain_values(chain, model.discount());
}

// Of the policy, with `bonus` for each step.
StateValues values_of(const SplitModel& model, const StatePolicy& policy, double bonus) {
  if (model.states() > kMostStates) return {};
  Chain chain;
  chain.reward.assign(index(model.states()), 0.0);
  for_states(model, [&](int state, int c, std::size_t s) {
    if (policy[index(state)] < 0) return;
    chain.reward[index(state)] = bonus;
    add_row(model, model.actions(c)[index(policy[index(state)])], c, s, 1.0, chain);
  });
  return values_of(model, chain);
}

// Policy iteration from the policy that `values` make best; empty if a policy on the way never ends.
StateValues iterated(const SplitModel& model, StateValues values, double direction, double bonus) {
  StatePolicy policy(index(model.states()), -1);
  for (int round = 0; round < kMostImprovements && !values.empty(); ++round) {
    double size = model.largest_reward();
    for (const double value : values) size = std::max(size, std::abs(value));
    bool changed = false;
    for_states(model, [&](int state, int c, std::size_t s) {
      int& chosen = policy[index(state)];
      const auto& actions = model.actions(c);
      double best = chosen < 0 ? 0.0 : worth(model, actions[index(chosen)], s, values);
      for (int a = 0; a < static_cast<int>(actions.size()); ++a) {
        const double now = worth(model, actions[index(a)], s, values);
        if (chosen >= 0 && direction * (now - best) <= kBetter * size) continue;
        chosen = a;
        best = now;
        changed = true;
      }
    });
    if (!changed) break;
    values = values_of(model, policy, bonus);
  }
  return values;
}

StateValues random_values(const SplitModel& model, double bonus) {
  if (model.states() > kMostStates) return {};
  Chain chain;
  chain.reward.assign(index(model.states()), 0.0);
  for_states(model, [&](int state, int c, std::size_t s) {
    const auto& actions = model.actions(c);
    if (actions.empty()) return;
    chain.reward[index(state)] = bonus;
    for (const ClassAction& action : actions) {
      add_row(model, action, c, s, 1.0 / static_cast<double>(actions.size()), chain);
    }
  });
  return values_of(model, chain);
}

}  // namespace

StateValues direct_policy_values(const SplitModel& model, const StatePolicy& policy) {
  return values_of(model, policy, 0.0);
}

StateValues direct_mdp_values(const SplitModel& model, double direction) {
  return iterated(model, random_values(model, 0.0), direction, 0.0);
}

StateValues random_values(const SplitModel& model) { return random_values(model, 0.0); }

double steps_to_end(const SplitModel& model) {
  if (model.states() > kMostStates) {
    throw std::invalid_argument("a discount of 1 without a horizon is solved for at most " +
                                std::to_string(kMostStates) + " states; give a horizon or a discount");
  }
  const StateValues random = random_values(model, 0.0);
  if (random.empty()) {
    throw std::invalid_argument(
        "the discount is 1, there is no horizon, and from some state no action ever leads to an end; "
        "give a horizon, or a discount below 1");
  }
  // With a bonus for each step the best policy still ends: so a policy that never does costs more than the
  // bonus. One that is worth as much as acting at random takes no more steps than the bonus may buy.
  for (double bonus = 0.5 * model.largest_reward(); bonus > 1e-9 * model.largest_reward(); bonus *= 0.25) {
    const StateValues best = iterated(model, random_values(model, bonus), 1.0, bonus);
    if (best.empty()) continue;
    double steps = 1.0;
    for (std::size_t i = 0; i < best.size(); ++i) steps = std::max(steps, (best[i] - random[i]) / bonus);
    return steps;
  }
  if (model.largest_reward() == 0.0) return 1.0;
  throw std::invalid_argument(
      "the discount is 1, there is no horizon, and a policy that never ends costs nothing in the long run; "
      "give a horizon, a discount below 1, or a cost for each step");
}

ActionValues direct_fib_values(const SplitModel& model, const ActionValues& start) {
  // Each state and action is a node; after each outcome it goes on with the action that is best there.
  std::vector<std::size_t> begin;
  std::size_t nodes = 0;
  for (const auto& of_class : start) {
    begin.push_back(nodes);
    nodes += of_class.size();
  }
  if (nodes > kMostInformed) return {};
  std::vector<double> values;
  for (const auto& of_class : start) values.insert(values.end(), of_class.begin(), of_class.end());
  std::vector<std::vector<std::size_t>> plans(nodes);  // the next action, of each node's outcomes in turn
  for (int round = 0; round < kMostImprovements; ++round) {
    double size = model.largest_reward();
    for (const double value : values) size = std::max(size, std::abs(value));
    Chain chain;
    bool changed = false;
    for_states(model, [&](int, int c, std::size_t s) {
      const auto& actions = model.actions(c);
      for (std::size_t a = 0; a < actions.size(); ++a) {
        const ClassAction& action = actions[a];
        const auto node = static_cast<int>(chain.reward.size());
        chain.reward.push_back(action.reward[s]);
        std::vector<std::size_t>& plan = plans[index(node)];
        std::size_t met = 0;
        int i = action.row_begin[s];
        while (i < action.row_begin[s + 1]) {
          const int outcome = action.outcome_of[index(action.column[index(i)])];
          const int c2 = action.outcomes[index(outcome)].next_class;
          const std::size_t width = model.actions(c2).size();
          const int from = i;
          std::vector<double> sums(width, 0.0);
          const auto row = [&](int at) {
            return begin[index(c2)] +
                   index(action.next[index(action.column[index(at)])] - model.first(c2)) * width;
          };
          for (; i < action.row_begin[s + 1] && action.outcome_of[index(action.column[index(i)])] == outcome;
               ++i) {
            for (std::size_t b = 0; b < width; ++b) sums[b] += action.weight[index(i)] * values[row(i) + b];
          }
          if (width == 0) continue;
          const auto best =
              static_cast<std::size_t>(std::max_element(sums.begin(), sums.end()) - sums.begin());
          if (met == plan.size()) {
            plan.push_back(best);
            changed = true;
          } else if (sums[best] > sums[plan[met]] + kBetter * size) {
            plan[met] = best;
            changed = true;
          }
          for (int k = from; k < i; ++k) {
            chain.lead(node, static_cast<int>(row(k) + plan[met]), action.weight[index(k)]);
          }
          ++met;
        }
      }
    });
    if (!changed) break;
    values = chain_values(chain, model.discount());
    if (values.empty()) return {};
  }
  ActionValues result;
  for (std::size_t c = 0; c < start.size(); ++c) {
    const auto from = values.begin() + static_cast<std::ptrdiff_t>(begin[c]);
    result.emplace_back(from, from + static_cast<std::ptrdiff_t>(start[c].size()));
  }
  return result;
}

}  // namespace hypgen::exact
