// SPDX-License-Identifier: Apache-2.0
// A small model as sparse matrices: every state that can be reached, every outcome of every action.
//
// Knows no model's types; `enumerate` (enumerate.hpp) makes one from a generated model.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstdint>
#include <vector>

#include "hypgen/exact/text_rounding.hpp"

namespace hypgen::exact {

using SparseMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// Probabilities of states, of one class (see `ExactModel`).
using SparseBelief = Eigen::SparseVector<double>;

// What an action does. An outcome that does not end the episode is a pair (observation, next state); each
// pair that can occur is a column. Columns are sorted by observation, then by next state.
struct ExactAction {
  SparseMatrix outcomes;          // states x columns; a row sums to 1 - P(terminal), to 0 where not legal
  std::vector<int> next;          // of each column
  std::vector<int> observations;  // that can occur, ascending: indexes of observations of the model
  std::vector<int> begin;         // observations[i] has the columns begin[i] .. begin[i + 1] - 1
  Eigen::VectorXd reward;         // expected, of each state, terminal outcomes included; -inf where not legal
};

// How an episode may start: what is visible, and the belief given that.
struct ExactStart {
  double probability;
  std::vector<std::int32_t> visible;  // as `export_visible` gives it
  SparseBelief belief;
};

// States are numbered by class: states of one class agree in all that is visible (and in time, where there
// is a horizon), so a belief never spans two, and legality is the same in all of them. A state in which no
// action is legal is worth 0; terminal outcomes leave the model, and so do all outcomes of the last step
// before a horizon.
struct ExactModel {
  double discount = 1.0;
  int horizon = 0;  // 0: none; otherwise outcomes never lead back, as time is part of the state
  int states = 0;
  int observations = 0;  // different keys that can be seen after any action
  std::vector<ExactAction> actions;
  std::vector<ExactStart> starts;
  std::vector<int> seen;         // the class of each state; does not fall from state to state
  std::vector<int> class_begin;  // class c has the states class_begin[c] .. class_begin[c + 1] - 1

  TextRounding rounding;

  // What states and observations stand for.
  int variables = 0;
  std::vector<std::int32_t> values;  // states x variables, as `export_state` gives them
  std::vector<int> steps;            // taken until a state; empty without a horizon
  int key_words = 1;
  std::vector<std::uint64_t> keys;  // observations x words, ascending

  int classes() const { return static_cast<int>(class_begin.size()) - 1; }
};

}  // namespace hypgen::exact
