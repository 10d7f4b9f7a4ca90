// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "hypgen/exact/long_run.hpp"

namespace hypgen::exact {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Sweeps end when all that are left out could not change a value by more than this part of the largest one.
constexpr double kEnough = 1e-7;
// The same for the fast informed bound, whose sweeps cost more and which a search lowers in any case.
constexpr double kEnoughInformed = 1e-4;
// Where episodes end soon, so many sweeps show how soon.
constexpr int kStaySweeps = 100;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

double action_value(const ClassAction& action, std::size_t state, double discount,
                    const StateValues& values) {
  double sum = 0.0;
  for (int i = action.row_begin[state]; i < action.row_begin[state + 1]; ++i) {
    sum += action.weight[index(i)] * values[index(action.next[index(action.column[index(i)])])];
  }
  return action.reward[state] + discount * sum;
}

double largest(const StateValues& values) {
  double most = 0.0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

// Sweeps with `value(class, state, values)` from the last state to the first, as later states of a model with
// a horizon have larger numbers. Values go towards `direction` (1: up) and never back. A last sweep looks
// whether rounding has carried one too far, by what large values were rounded that no longer stand there.
template <class Value>
void sweep_until_still(const SplitModel& model, double direction, StateValues& values,
                       const KeepGoing& keep_going, Value value) {
  const auto sweep = [&](auto visit) {
    for (int c = model.classes() - 1; c >= 0; --c) {
      for (int s = model.size(c) - 1; s >= 0; --s) {
        double& old = values[index(model.first(c) + s)];
        visit(old, value(c, index(s), values));
      }
    }
  };
  double change = kInfinity;
  while (change * model.steps() > kEnough * std::max(largest(values), model.largest_reward()) &&
         keep_going()) {
    change = 0.0;
    sweep([&](double& old, double now) {
      if (direction * (now - old) <= 0.0) return;
      change = std::max(change, std::abs(now - old));
      old = now;
    });
  }
  double too_far = 0.0;
  sweep([&](const double& old, double now) { too_far = std::max(too_far, direction * (old - now)); });
  for (double& one : values) one -= direction * too_far * model.steps();
}

StateValues start_values(const SplitModel& model, double value) {
  return StateValues(index(model.states()), value);
}

// A state's Q-values start at `q`; an action's fast informed value there.
double fib_value(const SplitModel& model, const ClassAction& action, std::size_t state,
                 const ActionValues& values, std::vector<double>& sums) {
  double total = 0.0;
  int i = action.row_begin[state];
  const int end = action.row_begin[state + 1];
  while (i < end) {
    const int outcome = action.outcome_of[index(action.column[index(i)])];
    const int next_class = action.outcomes[index(outcome)].next_class;
    const std::size_t width = model.actions(next_class).size();
    sums.assign(width, 0.0);
    for (; i < end && action.outcome_of[index(action.column[index(i)])] == outcome; ++i) {
      const int next = action.next[index(action.column[index(i)])] - model.first(next_class);
      const double* row = values[index(next_class)].data() + index(next) * width;
      for (std::size_t a = 0; a < width; ++a) sums[a] += action.weight[index(i)] * row[a];
    }
    if (width > 0) total += *std::max_element(sums.begin(), sums.end());
  }
  return action.reward[state] + model.discount() * total;
}

// One sweep of the fast informed bound over a class; returns the largest change.
double sweep_fib(const SplitModel& model, int of_class, ActionValues& values, std::vector<double>& sums) {
  const auto& actions = model.actions(of_class);
  double change = 0.0;
  for (int s = model.size(of_class) - 1; s >= 0; --s) {
    for (std::size_t a = 0; a < actions.size(); ++a) {
      double& old = values[index(of_class)][index(s) * actions.size() + a];
      const double now = fib_value(model, actions[a], index(s), values, sums);
      if (now >= old) continue;
      change = std::max(change, old - now);
      old = now;
    }
  }
  return change;
}

StateValues or_else(StateValues values, StateValues otherwise) {
  return values.empty() ? std::move(otherwise) : std::move(values);
}

// Values that are the fast informed bound but for rounding, as bounds.
ActionValues lifted(const SplitModel& model, ActionValues values) {
  std::vector<double> sums;
  double low = 0.0;
  for (int c = 0; c < model.classes(); ++c) {
    const auto& actions = model.actions(c);
    for (int s = 0; s < model.size(c); ++s) {
      for (std::size_t a = 0; a < actions.size(); ++a) {
        const double now = fib_value(model, actions[a], index(s), values, sums);
        low = std::max(low, now - values[index(c)][index(s) * actions.size() + a]);
      }
    }
  }
  for (auto& of_class : values) {
    for (double& value : of_class) value += low * model.steps();
  }
  return values;
}

double largest_reward(const SplitModel& model, double sign) {
  double largest = 0.0;
  for (int c = 0; c < model.classes(); ++c) {
    for (const ClassAction& action : model.actions(c)) {
      for (const double reward : action.reward) largest = std::max(largest, sign * reward);
    }
  }
  return largest;
}

}  // namespace

double longest_stay(const SplitModel& model, const KeepGoing& keep_going) {
  // What a reward of 1 a step comes to at most, from above.
  StateValues values = start_values(model, model.steps());
  for (int sweep = 0; sweep < kStaySweeps && keep_going(); ++sweep) {
    for (int c = model.classes() - 1; c >= 0; --c) {
      for (int s = model.size(c) - 1; s >= 0; --s) {
        double most = 0.0;
        for (const ClassAction& action : model.actions(c)) {
          double sum = 0.0;
          for (int i = action.row_begin[index(s)]; i < action.row_begin[index(s) + 1]; ++i) {
            sum += action.weight[index(i)] * values[index(action.next[index(action.column[index(i)])])];
          }
          most = std::max(most, 1.0 + model.discount() * sum);
        }
        double& old = values[index(model.first(c) + s)];
        old = std::min(old, most);
      }
    }
  }
  return largest(values);
}

StateValues mdp_values(const SplitModel& model, const KeepGoing& keep_going) {
  StateValues values = or_else(model.is_long() ? direct_mdp_values(model, 1.0) : StateValues(),
                               start_values(model, largest_reward(model, 1.0) * model.steps()));
  sweep_until_still(model, -1.0, values, keep_going, [&](int c, std::size_t s, const StateValues& old) {
    double best = -kInfinity;
    for (const ClassAction& action : model.actions(c)) {
      best = std::max(best, action_value(action, s, model.discount(), old));
    }
    return model.actions(c).empty() ? 0.0 : best;
  });
  return values;
}

StateValues worst_values(const SplitModel& model, const KeepGoing& keep_going) {
  if (model.is_endless()) return random_values(model);
  StateValues values = or_else(model.is_long() ? direct_mdp_values(model, -1.0) : StateValues(),
                               start_values(model, -largest_reward(model, -1.0) * model.steps()));
  sweep_until_still(model, 1.0, values, keep_going, [&](int c, std::size_t s, const StateValues& old) {
    double worst = kInfinity;
    for (const ClassAction& action : model.actions(c)) {
      worst = std::min(worst, action_value(action, s, model.discount(), old));
    }
    return model.actions(c).empty() ? 0.0 : worst;
  });
  return values;
}

ActionValues qmdp_values(const SplitModel& model, const StateValues& mdp) {
  ActionValues values(index(model.classes()));
  for (int c = 0; c < model.classes(); ++c) {
    for (int s = 0; s < model.size(c); ++s) {
      for (const ClassAction& action : model.actions(c)) {
        values[index(c)].push_back(action_value(action, index(s), model.discount(), mdp));
      }
    }
  }
  return values;
}

ActionValues fib_values(const SplitModel& model, ActionValues values, const KeepGoing& keep_going) {
  if (model.is_long() && !model.is_endless()) {
    ActionValues direct = direct_fib_values(model, values);
    if (!direct.empty()) return lifted(model, std::move(direct));
  }
  std::vector<double> sums;
  double most = 0.0;
  for (const auto& of_class : values) most = std::max(most, largest(of_class));
  double change = kInfinity;
  while (change * model.steps() > kEnoughInformed * most && keep_going()) {
    change = 0.0;
    for (int c = model.classes() - 1; c >= 0 && keep_going(); --c) {
      change = std::max(change, sweep_fib(model, c, values, sums));
    }
  }
  return values;
}

ClassPolicy blind_policy(const SplitModel& model, int action) {
  ClassPolicy policy;
  for (int c = 0; c < model.classes(); ++c) {
    const auto& actions = model.actions(c);
    const auto found = std::find_if(actions.begin(), actions.end(),
                                    [action](const ClassAction& one) { return one.action == action; });
    const int legal = found == actions.end() ? 0 : static_cast<int>(found - actions.begin());
    policy.push_back(actions.empty() ? -1 : legal);
  }
  return policy;
}

StateValues policy_values(const SplitModel& model, const ClassPolicy& policy, const KeepGoing& keep_going) {
  StateValues values;
  if (model.is_long()) {
    StatePolicy everywhere;
    for (int c = 0; c < model.classes(); ++c) {
      everywhere.insert(everywhere.end(), index(model.size(c)), policy[index(c)]);
    }
    values = direct_policy_values(model, everywhere);
    if (values.empty() && model.is_endless()) return {};
  }
  values = or_else(std::move(values), start_values(model, -largest_reward(model, -1.0) * model.steps()));
  sweep_until_still(model, 1.0, values, keep_going, [&](int c, std::size_t s, const StateValues& old) {
    if (policy[index(c)] < 0) return 0.0;
    return action_value(model.actions(c)[index(policy[index(c)])], s, model.discount(), old);
  });
  return values;
}

double best_value(const SplitModel& model, const ActionValues& values, int of_class,
                  const std::vector<int>& states, const std::vector<double>& probabilities) {
  const std::size_t width = model.actions(of_class).size();
  if (width == 0) return 0.0;
  std::vector<double> sums(width, 0.0);
  for (std::size_t i = 0; i < states.size(); ++i) {
    const double* row = values[index(of_class)].data() + index(states[i]) * width;
    for (std::size_t a = 0; a < width; ++a) sums[a] += probabilities[i] * row[a];
  }
  return *std::max_element(sums.begin(), sums.end());
}

}  // namespace hypgen::exact
