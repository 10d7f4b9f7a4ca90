// SPDX-License-Identifier: Apache-2.0
// Rows of words, each kept once under a number.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace hypgen::exact {

// Numbers count up from 0 in the order in which rows first came.
template <class Word>
class RowTable {
 public:
  explicit RowTable(std::size_t width) : width_(width), slots_(kFirstSlots, kEmpty) {}

  int number(const Word* row) {
    std::size_t slot = hash(row) & (slots_.size() - 1);
    for (; slots_[slot] != kEmpty; slot = (slot + 1) & (slots_.size() - 1)) {
      if (std::equal(row, row + width_, this->row(slots_[slot]))) return slots_[slot];
    }
    const int added = size_++;
    slots_[slot] = added;
    words_.insert(words_.end(), row, row + width_);
    if (2 * static_cast<std::size_t>(size_) > slots_.size()) grow();
    return added;
  }

  // Void once another row is added.
  const Word* row(int number) const { return words_.data() + static_cast<std::size_t>(number) * width_; }

  int size() const { return size_; }

  std::size_t bytes() const { return words_.capacity() * sizeof(Word) + slots_.size() * sizeof(int); }

 private:
  static constexpr int kEmpty = -1;
  static constexpr std::size_t kFirstSlots = 64;

  std::size_t hash(const Word* row) const {
    std::uint64_t value = width_;
    for (std::size_t i = 0; i < width_; ++i) {
      value = (value ^ row[i]) * 0x9E3779B97F4A7C15U;
      value ^= value >> 29;
    }
    return static_cast<std::size_t>(value ^ value >> 32);
  }

  void grow() {
    slots_.assign(2 * slots_.size(), kEmpty);
    for (int number = 0; number < size_; ++number) {
      std::size_t slot = hash(row(number)) & (slots_.size() - 1);
      while (slots_[slot] != kEmpty) slot = (slot + 1) & (slots_.size() - 1);
      slots_[slot] = number;
    }
  }

  std::size_t width_;
  int size_ = 0;
  std::vector<Word> words_;
  std::vector<int> slots_;
};

}  // namespace hypgen::exact
