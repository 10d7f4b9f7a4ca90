// SPDX-License-Identifier: Apache-2.0
// Numbers keys by first appearance.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hypgen/model/key.hpp"

namespace hypgen {

// A hash table with linear probing whose entries expire all at once, by a stamp.
template <class Key>
class Grouping {
 public:
  explicit Grouping(std::size_t max_keys) {
    while ((std::size_t{1} << bits_) < 2 * max_keys) ++bits_;
    slots_.resize(std::size_t{1} << bits_);
  }

  // Forgets all keys.
  void clear() {
    count_ = 0;
    if (++stamp_ == 0) {
      for (Slot& slot : slots_) slot.stamp = 0;
      stamp_ = 1;
    }
  }

  // The number of `key`; a new key gets the next number.
  std::uint32_t number(const Key& key) {
    std::size_t at = key_hash(key) >> (64 - bits_);
    while (slots_[at].stamp == stamp_) {
      if (slots_[at].key == key) return slots_[at].group;
      at = (at + 1) & (slots_.size() - 1);
    }
    slots_[at] = {key, stamp_, count_};
    return count_++;
  }

  // Takes the next number for a group that has no key.
  std::uint32_t next_number() { return count_++; }

  std::uint32_t count() const { return count_; }

 private:
  struct Slot {
    Key key{};
    std::uint32_t stamp = 0;
    std::uint32_t group = 0;
  };

  unsigned bits_ = 1;
  std::uint32_t stamp_ = 0;
  std::uint32_t count_ = 0;
  std::vector<Slot> slots_;
};

// Groups the scenarios of one action: by observation key, with the terminal ones apart.
template <class Key>
class ActionGrouping {
 public:
  explicit ActionGrouping(std::size_t max_scenarios) : keys_(max_scenarios) {}

  void clear() {
    keys_.clear();
    terminal_ = kNone;
  }

  std::uint32_t number(bool terminal, const Key& key) {
    if (!terminal) return keys_.number(key);
    if (terminal_ == kNone) terminal_ = keys_.next_number();
    return terminal_;
  }

  std::uint32_t count() const { return keys_.count(); }

 private:
  static constexpr std::uint32_t kNone = UINT32_MAX;
  Grouping<Key> keys_;
  std::uint32_t terminal_ = kNone;
};

}  // namespace hypgen
