// SPDX-License-Identifier: Apache-2.0
#include "matrices.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace hypgen::exact {

namespace {

std::size_t at(int number) { return static_cast<std::size_t>(number); }

// An order of states or observations, and its inverse.
struct Order {
  std::vector<int> found;   // the number under which each was found
  std::vector<int> number;  // in the model, of each that was found

  explicit Order(int count) : found(at(count)), number(at(count)) {
    std::iota(found.begin(), found.end(), 0);
  }

  void invert() {
    for (std::size_t i = 0; i < found.size(); ++i) number[at(found[i])] = static_cast<int>(i);
  }
};

// States of a class one after the other, classes and their states in the order in which they were found.
Order order_states(const OutcomeModel& model, const Found& found, ExactModel& result) {
  Order order(found.states.size());
  RowTable<std::int32_t> classes(at(model.visible()) + 1);
  std::vector<std::int32_t> row(at(model.visible()) + 1);
  std::vector<int> of_state(order.found.size());
  for (int state = 0; state < found.states.size(); ++state) {
    const std::uint32_t* const words = found.states.row(state);
    model.export_visible(words, row.data());
    row.back() = static_cast<std::int32_t>(words[model.state_words()]);
    of_state[at(state)] = classes.number(row.data());
  }
  std::stable_sort(order.found.begin(), order.found.end(),
                   [&](int a, int b) { return of_state[at(a)] < of_state[at(b)]; });
  order.invert();
  for (const int state : order.found) {
    if (of_state[at(state)] == static_cast<int>(result.class_begin.size())) {
      result.class_begin.push_back(static_cast<int>(result.seen.size()));
    }
    result.seen.push_back(of_state[at(state)]);
  }
  result.class_begin.push_back(static_cast<int>(result.seen.size()));
  return order;
}

Order order_keys(const Found& found, std::size_t words) {
  Order order(found.keys.size());
  std::sort(order.found.begin(), order.found.end(), [&](int a, int b) {
    const std::uint64_t *const first = found.keys.row(a), *const second = found.keys.row(b);
    return std::lexicographical_compare(first, first + words, second, second + words);
  });
  order.invert();
  return order;
}

// A column's place in the order of columns.
std::uint64_t column_key(int observation, int next) {
  return std::uint64_t{static_cast<std::uint32_t>(observation)} << 32 | static_cast<std::uint32_t>(next);
}

// Fills in the columns; returns their keys.
std::vector<std::uint64_t> list_columns(const FoundAction& found, ExactAction& action) {
  std::vector<std::uint64_t> columns;
  columns.reserve(found.entries.size());
  for (const Entry& entry : found.entries) columns.push_back(column_key(entry.observation, entry.next));
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  for (const std::uint64_t key : columns) {
    const auto observation = static_cast<int>(key >> 32);
    if (action.observations.empty() || action.observations.back() != observation) {
      action.observations.push_back(observation);
      action.begin.push_back(static_cast<int>(action.next.size()));
    }
    action.next.push_back(static_cast<int>(key & UINT32_MAX));
  }
  action.begin.push_back(static_cast<int>(action.next.size()));
  return columns;
}

ExactAction make_action(const Order& states, const Order& keys, FoundAction& found) {
  for (Entry& entry : found.entries) {
    entry.observation = keys.number[at(entry.observation)];
    entry.next = states.number[at(entry.next)];
  }
  ExactAction action;
  const std::vector<std::uint64_t> columns = list_columns(found, action);
  const auto count = static_cast<Eigen::Index>(states.found.size());
  action.reward.resize(count);
  action.outcomes.resize(count, static_cast<Eigen::Index>(columns.size()));
  action.outcomes.resizeNonZeros(static_cast<Eigen::Index>(found.entries.size()));
  int* const begin = action.outcomes.outerIndexPtr();
  int filled = 0;
  for (Eigen::Index state = 0; state < count; ++state) {
    const std::size_t old = at(states.found[static_cast<std::size_t>(state)]);
    const auto first = found.entries.begin() + static_cast<std::ptrdiff_t>(found.begin[old]);
    const auto last = found.entries.begin() + static_cast<std::ptrdiff_t>(found.begin[old + 1]);
    std::sort(first, last, [](const Entry& a, const Entry& b) {
      return column_key(a.observation, a.next) < column_key(b.observation, b.next);
    });
    begin[state] = filled;
    for (auto entry = first; entry != last; ++entry, ++filled) {
      const std::uint64_t key = column_key(entry->observation, entry->next);
      const auto column = std::lower_bound(columns.begin(), columns.end(), key) - columns.begin();
      action.outcomes.innerIndexPtr()[filled] = static_cast<int>(column);
      action.outcomes.valuePtr()[filled] = entry->probability;
    }
    action.reward[state] = found.reward[old];
  }
  begin[count] = filled;
  found = FoundAction();
  return action;
}

// Initial states of one class are one start.
void make_starts(const OutcomeModel& model, const Order& states, Found& found, ExactModel& result) {
  for (Entry& entry : found.starts) entry.next = states.number[at(entry.next)];
  std::sort(found.starts.begin(), found.starts.end(),
            [](const Entry& a, const Entry& b) { return a.next < b.next; });
  for (auto first = found.starts.begin(), last = first; first != found.starts.end(); first = last) {
    ExactStart start{0.0, std::vector<std::int32_t>(at(model.visible())), SparseBelief(result.states)};
    const int of_class = result.seen[at(first->next)];
    while (last != found.starts.end() && result.seen[at(last->next)] == of_class) {
      start.probability += (last++)->probability;
    }
    for (auto entry = first; entry != last; ++entry) {
      start.belief.insertBack(entry->next) = entry->probability / start.probability;
    }
    model.export_visible(found.states.row(states.found[at(first->next)]), start.visible.data());
    result.starts.push_back(std::move(start));
  }
}

}  // namespace

void make_matrices(const OutcomeModel& model, Found& found, ExactModel& result) {
  result.states = found.states.size();
  result.observations = found.keys.size();
  result.variables = model.variables();
  result.key_words = model.key_words();
  const Order states = order_states(model, found, result);
  const Order keys = order_keys(found, at(result.key_words));
  make_starts(model, states, found, result);
  for (FoundAction& action : found.actions) result.actions.push_back(make_action(states, keys, action));
  result.values.resize(at(result.states) * at(result.variables));
  for (int state = 0; state < result.states; ++state) {
    const std::uint32_t* const words = found.states.row(states.found[at(state)]);
    model.export_state(words, result.values.data() + at(state) * at(result.variables));
    if (result.horizon > 0) result.steps.push_back(static_cast<int>(words[model.state_words()]));
  }
  for (const int key : keys.found) {
    const std::uint64_t* const words = found.keys.row(key);
    result.keys.insert(result.keys.end(), words, words + result.key_words);
  }
}

}  // namespace hypgen::exact
