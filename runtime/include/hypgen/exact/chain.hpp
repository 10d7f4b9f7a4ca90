// SPDX-License-Identifier: Apache-2.0
// A Markov chain with rewards: what it earns for ever, as the solution of linear equations.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

namespace hypgen::exact {

// What is missing to 1 in the weights that leave a node ends the chain. A node may have several entries that
// lead to the same other.
struct Chain {
  using Entry = Eigen::Triplet<double>;  // (from, to, weight)

  std::vector<double> reward;  // of each node
  std::vector<Entry> entries;

  void lead(int from, int to, double weight) {
    if (weight != 0.0) entries.emplace_back(from, to, weight);
  }
};

// What the chain earns from each node. Empty where the equations have no solution: with a discount of 1 some
// node never comes to an end.
std::vector<double> chain_values(const Chain& chain, double discount);

// How often each node is met, discounted, from a start with those weights. Empty as above.
std::vector<double> chain_visits(const Chain& chain, double discount, const std::vector<double>& start);

// Whether an end can be reached from each node.
bool ends_always(const Chain& chain);

// How many steps it takes from some node on average, to the end that `ends_always`.
double most_steps(Chain chain);

}  // namespace hypgen::exact
