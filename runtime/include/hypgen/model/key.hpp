// SPDX-License-Identifier: Apache-2.0
// Observation keys: what the agent saw in a step, as words that are equal where it was the same.
//
// A model's `Key` is a std::uint64_t where all that can be seen has a number below 2^64, otherwise a WideKey.
#pragma once

#include <cstddef>
#include <cstdint>

#include "hypgen/core/config.hpp"
#include "hypgen/core/span.hpp"

namespace hypgen {

// What code that knows no model sees of a key.
using KeyWords = Span<const std::uint64_t>;

// A key of N words. Digits fill the words in order, the first in the lowest place; one that no longer fits
// into its word starts the next.
template <std::size_t N>
struct WideKey {
  std::uint64_t words[N];
};

template <std::size_t N>
HYPGEN_FN bool operator==(const WideKey<N>& a, const WideKey<N>& b) {
  for (std::size_t i = 0; i < N; ++i) {
    if (a.words[i] != b.words[i]) return false;
  }
  return true;
}

template <class Key>
constexpr std::size_t kKeyWords = sizeof(Key) / sizeof(std::uint64_t);

HYPGEN_FN KeyWords words_of(const std::uint64_t& key) { return {&key, 1}; }
template <std::size_t N>
HYPGEN_FN KeyWords words_of(const WideKey<N>& key) {
  return {key.words, N};
}

// The key that has these words: kKeyWords<Key> of them.
template <class Key>
HYPGEN_FN Key key_from(KeyWords words) {
  if constexpr (kKeyWords<Key> == 1) {
    return words[0];
  } else {
    Key key;
    for (std::size_t i = 0; i < kKeyWords<Key>; ++i) key.words[i] = words[i];
    return key;
  }
}

// A number whose high bits differ for most keys.
HYPGEN_FN std::uint64_t key_hash(std::uint64_t key) { return key * 0x9E3779B97F4A7C15U; }
template <std::size_t N>
HYPGEN_FN std::uint64_t key_hash(const WideKey<N>& key) {
  std::uint64_t result = 0;
  for (std::size_t i = 0; i < N; ++i) {
    result = key_hash(result ^ key.words[i]);
    result ^= result >> 32;
  }
  return key_hash(result);
}

// Where the digits of a wide key lie: the same walk for whoever writes and whoever reads them.
class KeyCursor {
 public:
  // Moves to the word of the next digit, one of `size` values. Returns whether that is a new word.
  HYPGEN_FN bool advance(std::uint64_t size) {
    const bool full = largest_ > (UINT64_MAX - (size - 1)) / size;
    if (full) {
      ++word_;
      largest_ = 0;
    }
    place_ = largest_ + 1;
    largest_ = largest_ * size + (size - 1);
    return full;
  }

  HYPGEN_FN std::size_t word() const { return word_; }
  HYPGEN_FN std::uint64_t place() const { return place_; }  // what the digit counts in its word

 private:
  std::size_t word_ = 0;
  std::uint64_t place_ = 1;
  std::uint64_t largest_ = 0;  // that the digits so far can make of the word
};

// What a digit of a key says: a whole number from `low` on, or the bits of a float.
struct KeyDigit {
  std::uint64_t size;
  std::int64_t low;
  bool is_float;
};

// The values of a key, one for each digit; false if these digits make no such key. In a key of one word the first
// digit is the most significant.
HYPGEN_FN bool decode_key(const KeyDigit* digits, std::size_t count, KeyWords key, std::int32_t* values) {
  const bool is_wide = key.size() > 1;
  KeyCursor cursor;
  std::uint64_t rest = key[0];
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t i = is_wide ? n : count - 1 - n;
    const KeyDigit& digit = digits[i];
    if (is_wide && cursor.advance(digit.size)) {
      if (rest != 0) return false;  // more than the digits of the word before can say
      rest = key[cursor.word()];
    }
    const std::uint64_t higher = rest < digit.size ? 0 : rest / digit.size;  // a division is slow
    values[i] = static_cast<std::int32_t>(static_cast<std::int64_t>(rest - higher * digit.size) + digit.low);
    rest = higher;
  }
  return rest == 0;
}

// Writes the digits of a wide key in order.
template <class Key>
class KeyWriter {
 public:
  // `size` values, the digit being less; a size of 1 takes no room.
  HYPGEN_FN void put(std::uint64_t digit, std::uint64_t size) {
    cursor_.advance(size);
    key_.words[cursor_.word()] += digit * cursor_.place();
  }

  HYPGEN_FN const Key& key() const { return key_; }

 private:
  Key key_{};
  KeyCursor cursor_;
};

// Reads the digits of a wide key in order.
class KeyReader {
 public:
  HYPGEN_FN explicit KeyReader(KeyWords words) : words_(words), rest_(words[0]) {}

  HYPGEN_FN std::uint64_t take(std::uint64_t size) {
    if (cursor_.advance(size)) rest_ = words_[cursor_.word()];
    const std::uint64_t digit = rest_ % size;
    rest_ /= size;
    return digit;
  }

 private:
  KeyWords words_;
  KeyCursor cursor_;
  std::uint64_t rest_;
};

}  // namespace hypgen
