// SPDX-License-Identifier: Apache-2.0
// A hash of search trees, to show that two searches were the same, bit for bit.
#pragma once

#include <cstdint>
#include <cstring>

namespace hypgen {

// FNV-1a over 64-bit words.
class Signature {
 public:
  explicit Signature(std::uint64_t start = 0xCBF29CE484222325U) : value_(start) {}

  void add(std::uint64_t word) { value_ = (value_ ^ word) * 0x100000001B3U ^ (value_ >> 29); }

  void add(double number) {
    std::uint64_t bits;
    std::memcpy(&bits, &number, sizeof bits);
    add(bits);
  }

  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_;
};

}  // namespace hypgen
