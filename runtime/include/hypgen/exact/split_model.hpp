// SPDX-License-Identifier: Apache-2.0
// An enumerated model class by class, in the order in which its solver walks through it.
#pragma once

#include <cstddef>
#include <vector>

#include "hypgen/exact/exact_model.hpp"

namespace hypgen::exact {

// What is seen after an action: an observation, and with it the class of the next state.
struct Outcome {
  int observation = 0;
  int next_class = 0;
  int begin = 0;  // its columns: [begin, end)
  int end = 0;
};

// One legal action in all states of a class. A column is a pair (outcome, next state) that can occur.
struct ClassAction {
  int action;
  std::vector<double> reward;  // of each state of the class
  std::vector<int> row_begin;  // state i of the class has the entries row_begin[i] .. row_begin[i + 1] - 1
  std::vector<int> column;     // of each entry, ascending within a row
  std::vector<double> weight;  // of each entry: the pair's probability
  std::vector<Outcome> outcomes;
  std::vector<int> next;        // of each column: a state of the model
  std::vector<int> outcome_of;  // of each column
};

class SplitModel {
 public:
  explicit SplitModel(const ExactModel& model);

  int classes() const { return static_cast<int>(actions_.size()); }
  int states() const { return class_begin_.back(); }
  int first(int of_class) const { return class_begin_[static_cast<std::size_t>(of_class)]; }
  int size(int of_class) const { return first(of_class + 1) - first(of_class); }
  const std::vector<ClassAction>& actions(int of_class) const {
    return actions_[static_cast<std::size_t>(of_class)];
  }
  double discount() const { return discount_; }
  // The sum of the discounts of all steps that can be taken.
  double steps() const { return steps_; }
  double largest_reward() const { return largest_reward_; }
  // Whether so many steps count that sweeps and trials would take as many to see what they come to.
  bool is_long() const { return recurs_ && (steps_ > 1000.0 || discount_ == 1.0); }
  // Whether equations for loops pay: a search needs a trial for each step that counts, and they are few enough.
  bool closes_loops() const {
    const bool is_small = states() <= 400 && branches_ <= 20000;
    return recurs_ && (steps_ > 10.0 || discount_ == 1.0) && is_small;
  }
  // Whether an episode ends only where the model ends it: neither discount nor horizon do. `steps` is infinite
  // until `limit_steps` is told how many steps a policy takes that is worth looking at.
  bool is_endless() const { return recurs_ && discount_ == 1.0; }
  void limit_steps(double steps);
  // Whether an episode can end, in a state without actions or after an action.
  bool ends() const { return ends_; }
  // No value is larger.
  double most() const { return largest_reward_ * steps_; }
  // What all rounding together can change of a value, for each unit of the largest value.
  double rounding() const { return rounding_of_step_ * steps_; }

 private:
  void add_class(const ExactModel& model, const std::vector<char>& free, int of_class,
                 std::vector<int>& local);

  double discount_;
  bool ends_ = false;
  bool recurs_;  // states come again: time is no part of them
  double steps_;
  double largest_reward_ = 0.0;
  double rounding_of_step_ = 0.0;
  std::size_t branches_ = 0;  // outcomes of all actions in all states
  std::vector<int> class_begin_;
  std::vector<std::vector<ClassAction>> actions_;  // of each class, those that are legal there
};

}  // namespace hypgen::exact
