// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/chain.hpp"

#include <Eigen/SparseLU>
#include <algorithm>
#include <limits>

namespace hypgen::exact {
namespace {

// Weights that sum to 1 are off by less; an end that is rarer than this is none.
constexpr double kRarestEnd = 1e-13;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

// Of (1 - discount * weights) x = right, or of the transposed equations.
std::vector<double> solution(const Chain& chain, double discount, bool transposed,
                             const std::vector<double>& right) {
  const auto size = static_cast<Eigen::Index>(right.size());
  if (size == 0) return {};
  std::vector<Chain::Entry> entries;
  entries.reserve(chain.entries.size() + right.size());
  for (const Chain::Entry& entry : chain.entries) {
    const int row = transposed ? entry.col() : entry.row();
    const int column = transposed ? entry.row() : entry.col();
    entries.emplace_back(row, column, -discount * entry.value());
  }
  for (int i = 0; i < size; ++i) entries.emplace_back(i, i, 1.0);
  Eigen::SparseMatrix<double> equations(size, size);
  equations.setFromTriplets(entries.begin(), entries.end());
  Eigen::SparseLU<Eigen::SparseMatrix<double>> factors;
  factors.compute(equations);
  if (factors.info() != Eigen::Success) return {};
  const Eigen::Map<const Eigen::VectorXd> given(right.data(), size);
  Eigen::VectorXd values = factors.solve(given);
  // One step of refinement takes out what the factors were rounded by.
  values += factors.solve(Eigen::VectorXd(given - equations * values));
  if (!values.allFinite()) return {};
  return {values.data(), values.data() + size};
}

}  // namespace

std::vector<double> chain_values(const Chain& chain, double discount) {
  return solution(chain, discount, false, chain.reward);
}

std::vector<double> chain_visits(const Chain& chain, double discount, const std::vector<double>& start) {
  return solution(chain, discount, true, start);
}

bool ends_always(const Chain& chain) {
  const std::size_t size = chain.reward.size();
  std::vector<double> kept(size, 0.0);
  std::vector<std::vector<int>> before(size);
  for (const Chain::Entry& entry : chain.entries) {
    kept[index(entry.row())] += entry.value();
    before[index(entry.col())].push_back(entry.row());
  }
  std::vector<char> ends(size, 0);
  std::vector<int> reached;
  for (std::size_t i = 0; i < size; ++i) {
    if (kept[i] > 1.0 - kRarestEnd) continue;
    ends[i] = 1;
    reached.push_back(static_cast<int>(i));
  }
  for (std::size_t i = 0; i < reached.size(); ++i) {
    for (const int node : before[index(reached[i])]) {
      if (ends[index(node)] != 0) continue;
      ends[index(node)] = 1;
      reached.push_back(node);
    }
  }
  return reached.size() == size;
}

double most_steps(Chain chain) {
  chain.reward.assign(chain.reward.size(), 1.0);
  const std::vector<double> steps = chain_values(chain, 1.0);
  return steps.empty() ? std::numeric_limits<double>::infinity()
                       : *std::max_element(steps.begin(), steps.end());
}

}  // namespace hypgen::exact
