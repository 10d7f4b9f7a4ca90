// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/filter.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace hypgen::exact {

bool ExactFilter::init(const std::int32_t* visible) {
  for (const ExactStart& start : model_.starts) {
    if (!std::equal(start.visible.begin(), start.visible.end(), visible)) continue;
    belief_ = start.belief;
    likelihood_ = start.probability;
    return true;
  }
  return false;
}

bool ExactFilter::update(int number, KeyWords key) {
  const ExactAction& action = model_.actions[static_cast<std::size_t>(number)];
  const int observation = find_observation(model_, key);
  const auto found = std::lower_bound(action.observations.begin(), action.observations.end(), observation);
  if (found == action.observations.end() || *found != observation) return false;
  const auto group = static_cast<std::size_t>(found - action.observations.begin());
  const int begin = action.begin[group], end = action.begin[group + 1];
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(end - begin);  // of the observation's columns
  const int* const columns = action.outcomes.innerIndexPtr();
  for (SparseBelief::InnerIterator state(belief_); state; ++state) {
    const int* const last = columns + action.outcomes.outerIndexPtr()[state.index() + 1];
    const int* column = columns + action.outcomes.outerIndexPtr()[state.index()];
    for (column = std::lower_bound(column, last, begin); column != last && *column < end; ++column) {
      weights[*column - begin] += state.value() * action.outcomes.valuePtr()[column - columns];
    }
  }
  const double total = weights.sum();
  if (!(total > 0.0)) return false;
  SparseBelief next(model_.states);
  for (int column = begin; column < end; ++column) {  // ascending states
    const double weight = weights[column - begin];
    if (weight > 0.0) next.insertBack(action.next[static_cast<std::size_t>(column)]) = weight / total;
  }
  belief_ = std::move(next);
  likelihood_ = total;
  return true;
}

double ExactFilter::marginal(int variable, std::int32_t value) const {
  double sum = 0.0;
  for (SparseBelief::InnerIterator state(belief_); state; ++state) {
    const auto row = static_cast<std::size_t>(state.index()) * static_cast<std::size_t>(model_.variables);
    if (model_.values[row + static_cast<std::size_t>(variable)] == value) sum += state.value();
  }
  return sum;
}

int find_observation(const ExactModel& model, KeyWords key) {
  int low = 0, high = model.observations;
  const auto row = [&](int observation) {
    return model.keys.data() + static_cast<std::size_t>(observation) * key.size();
  };
  while (low < high) {
    const int middle = low + (high - low) / 2;
    if (std::lexicographical_compare(row(middle), row(middle) + key.size(), key.begin(), key.end())) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low < model.observations && std::equal(key.begin(), key.end(), row(low)) ? low : -1;
}

double total_variation(const SparseBelief& a, const SparseBelief& b) {
  const SparseBelief difference = a - b;
  return 0.5 * difference.cwiseAbs().sum();
}

}  // namespace hypgen::exact
