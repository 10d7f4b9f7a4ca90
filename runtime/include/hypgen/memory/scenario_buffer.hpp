// SPDX-License-Identifier: Apache-2.0
// Root states of a search, without their type.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace hypgen {

// `size` scenarios; scenario i draws under the number `first + i`. All have the one history that the agent
// has. Memory is reserved by `reserve` only.
class ScenarioBuffer {
 public:
  void reserve(std::size_t fixed_bytes, std::size_t state_bytes, std::size_t history_bytes,
               std::size_t capacity) {
    fixed_bytes_ = fixed_bytes;
    state_bytes_ = state_bytes;
    fixed_.resize(fixed_bytes * capacity);
    states_.resize(state_bytes * capacity);
    history_.resize(history_bytes);
    capacity_ = capacity;
    size_ = 0;
  }

  void clear(std::uint32_t first) {
    first_ = first;
    size_ = 0;
  }

  template <class Fixed, class State>
  void push(const Fixed& fixed, const State& state) {
    std::memcpy(fixed_.data() + size_ * fixed_bytes_, &fixed, sizeof fixed);
    std::memcpy(states_.data() + size_ * state_bytes_, &state, sizeof state);
    ++size_;
  }

  // Copies all scenarios to arrays of their types.
  template <class Fixed, class State>
  void copy_to(Fixed* fixed, State* states) const {
    std::memcpy(fixed, fixed_.data(), size_ * sizeof(Fixed));
    std::memcpy(states, states_.data(), size_ * sizeof(State));
  }

  template <class History>
  void set_history(const History& history) {
    std::memcpy(history_.data(), &history, sizeof history);
  }
  template <class History>
  void copy_history_to(History& history) const {
    std::memcpy(&history, history_.data(), sizeof history);
  }

  bool holds(std::size_t fixed_bytes, std::size_t state_bytes, std::size_t history_bytes) const {
    return fixed_bytes == fixed_bytes_ && state_bytes == state_bytes_ && history_bytes == history_.size();
  }
  std::size_t size() const { return size_; }
  std::size_t capacity() const { return capacity_; }
  std::uint32_t first() const { return first_; }

 private:
  std::size_t fixed_bytes_ = 0;
  std::size_t state_bytes_ = 0;
  std::size_t capacity_ = 0;
  std::size_t size_ = 0;
  std::uint32_t first_ = 0;
  std::vector<unsigned char> fixed_;
  std::vector<unsigned char> states_;
  std::vector<unsigned char> history_;
};

}  // namespace hypgen
