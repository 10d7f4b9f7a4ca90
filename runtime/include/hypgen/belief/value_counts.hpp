// SPDX-License-Identifier: Apache-2.0
// How many different values the particles of a unit have, exactly and in coarse cells.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <vector>

namespace hypgen {

// A set of hashes of values. Equal values count once.
class ValueSet {
 public:
  // For up to `most` values. Later sets of no more than these take no new memory.
  explicit ValueSet(std::size_t most = 0) { clear(most); }

  // Becomes an empty set for up to `most` values.
  void clear(std::size_t most) {
    std::size_t slots = 16;
    while (slots < 2 * most) slots *= 2;
    slots_.assign(slots, 0);
    size_ = 0;
  }

  void add(std::uint64_t hash) {
    const std::uint64_t stored = hash | 1;  // 0 stands for an empty slot
    std::size_t slot = static_cast<std::size_t>(hash >> 1) & (slots_.size() - 1);
    while (slots_[slot] != 0 && slots_[slot] != stored) slot = (slot + 1) & (slots_.size() - 1);
    size_ += slots_[slot] == 0;
    slots_[slot] = stored;
  }

  std::size_t size() const { return size_; }

  static std::uint64_t hash(const double* values, int count) {
    std::uint64_t sum = 0;
    for (int i = 0; i < count; ++i) {
      std::uint64_t bits;
      std::memcpy(&bits, values + i, sizeof bits);
      sum = mixed(sum ^ bits);
    }
    return sum;
  }

  // The hash of a value's bytes, and of those that another hash stands for.
  template <class T>
  static std::uint64_t hash_of(const T& value, std::uint64_t sum) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* const bytes = reinterpret_cast<const unsigned char*>(&value);
    for (std::size_t i = 0; i < sizeof value; i += sizeof sum) {
      std::uint64_t word = 0;
      std::memcpy(&word, bytes + i, std::min(sizeof word, sizeof value - i));
      sum = mixed(sum ^ word);
    }
    return sum;
  }

  // The finaliser of SplitMix64 (Steele, Lea and Flood, 2014).
  static std::uint64_t mixed(std::uint64_t x) {
    x += 0x9E3779B97F4A7C15;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EB;
    return x ^ (x >> 31);
  }

 private:
  std::vector<std::uint64_t> slots_;
  std::size_t size_ = 0;
};

// The range of each of a unit's values at the start, in which cells are counted.
template <int kValues>
class ValueScale {
 public:
  void clear() { count_ = 0; }

  void include(const double* values, int count) {
    for (int i = 0; i < count; ++i) {
      low_[i] = i < count_ ? std::min(low_[i], values[i]) : values[i];
      high_[i] = i < count_ ? std::max(high_[i], values[i]) : values[i];
    }
    count_ = count;
  }

  // The hash of the cell that has these values: a small part of the range of each.
  std::uint64_t cell(const double* values, int count) const {
    double cells[kValues + 1];
    for (int i = 0; i < count; ++i) {
      const double width = (high_[i] - low_[i]) / kCells;
      const double place = width > 0.0 ? (values[i] - low_[i]) / width : values[i];
      cells[i] = static_cast<double>(static_cast<std::int64_t>(std::clamp(place, -1e15, 1e15)));
    }
    return ValueSet::hash(cells, count);
  }

 private:
  static constexpr double kCells = 64.0;
  double low_[kValues + 1], high_[kValues + 1];
  int count_ = 0;
};

}  // namespace hypgen
