// SPDX-License-Identifier: Apache-2.0
// Entries of tables at a position of each lane, and bit fields of words in lanes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "hypgen/lanes/vectors.hpp"

namespace hypgen::lanes {

/// The 32-bit words at these positions.
HYPGEN_FN Word gather(const void* base, Int position) {
#if defined(HYPGEN_LANES_AVX512)
  return Word(reinterpret_cast<Full<std::uint32_t>>(
      _mm512_i32gather_epi32(reinterpret_cast<__m512i>(position.v), base, 4)));
#elif defined(__AVX2__)
  return Word(reinterpret_cast<Full<std::uint32_t>>(
      _mm256_i32gather_epi32(static_cast<const int*>(base), reinterpret_cast<__m256i>(position.v), 4)));
#else
  Word found;
  for (int i = 0; i < kLanes; ++i) found.set(i, static_cast<const std::uint32_t*>(base)[position[i]]);
  return found;
#endif
}

/// The entries of a table at these positions; a position outside, of a lane that does not count, gives the last.
template <class T>
HYPGEN_FN auto entries(const T* table, std::size_t count, Int position) {
  const Word last(static_cast<std::uint32_t>(count - 1)), wanted = as<std::uint32_t>(position);
  const Int place = as<std::int32_t>(select_lanes<std::uint32_t>(wanted < last, wanted, last));
  if constexpr (sizeof(T) == 8) {
    Lanes<T> found;
    for (int i = 0; i < kLanes; ++i) found.set(i, table[place[i]]);
    return found;
  } else if constexpr (std::is_same_v<T, float>) {
    return from_bits(gather(table, place));
  } else if constexpr (sizeof(T) == 4) {
    return as<T>(gather(table, place));
  } else {
    // The aligned words that the entries lie in: none lies in two.
    const auto address = reinterpret_cast<std::uintptr_t>(table);
    const Word byte = as<std::uint32_t>(place) * Word(std::uint32_t{sizeof(T)}) +
                      Word(static_cast<std::uint32_t>(address & 3));
    const Word word =
        gather(reinterpret_cast<const void*>(address & ~std::uintptr_t{3}), as<std::int32_t>(byte >> 2U));
    const Word moved = word >> ((byte & 3U) << 3U);
    if constexpr (std::is_same_v<T, bool>) {
      return (moved & 1U) != Word(0U);
    } else if constexpr (std::is_unsigned_v<T>) {
      return as<std::int32_t>(moved & Word((1U << (8 * sizeof(T))) - 1));
    } else {
      constexpr int kUpper = 32 - 8 * static_cast<int>(sizeof(T));
      return Int(as<std::int32_t>(moved << Word(static_cast<std::uint32_t>(kUpper))).v >> kUpper);
    }
  }
}

template <class T>
struct Flat {
  using type = T;
  static constexpr std::size_t kCount = 1;
};
template <class T, std::size_t N>
struct Flat<T[N]> {
  using type = typename Flat<T>::type;
  static constexpr std::size_t kCount = N * Flat<T>::kCount;
};

template <class T, class Place>
HYPGEN_FN auto flat_position(Place place) {
  return place;
}
template <class T, class Place, class Next, class... Rest>
HYPGEN_FN auto flat_position(Place place, Next next, Rest... rest) {
  constexpr auto kLength = static_cast<std::int32_t>(std::extent_v<T>);
  return flat_position<std::remove_extent_t<T>>(place * kLength + next, rest...);
}

template <class T>
struct IsLanes : std::bool_constant<kHasLanes<T>> {};

/// `table[i][j]..`: one entry, or an entry of each lane.
template <class T, std::size_t N, class I, class... Rest>
HYPGEN_FN auto at(const T (&table)[N], I first, Rest... rest) {
  using Entry = typename Flat<T>::type;
  if constexpr (kHasLanes<Entry>) {
    if constexpr (kHasLanes<I>) {  // a position of each lane
      Entry found = table[0];
      for (std::size_t i = 1; i < N; ++i) assign(first == Int(static_cast<std::int32_t>(i)), found, table[i]);
      return found;
    } else if constexpr (sizeof...(Rest) == 0) {
      return table[first];
    } else {
      return at(table[first], rest...);
    }
  } else if constexpr (!(kHasLanes<I> || ... || kHasLanes<Rest>)) {
    if constexpr (sizeof...(Rest) == 0) {
      return table[first];
    } else {
      return at(table[first], rest...);
    }
  } else {
    return entries(reinterpret_cast<const Entry*>(table), Flat<T[N]>::kCount,
                   Int(flat_position<T>(first, rest...)));
  }
}
/// What is called with its position, or behind a pointer.
template <class T, class I, std::enable_if_t<!std::is_array_v<T>, int> = 0>
HYPGEN_FN auto at(const T& owner, I position) {
  return owner[position];
}

/// Gives an entry of each of the lanes of `mask` a new value.
template <class T, std::size_t N, class V>
HYPGEN_FN void put_at(Mask mask, Lanes<T> (&array)[N], std::int32_t position, const V& value) {
  assign(mask, array[position], value);
}
template <class T, std::size_t N, class V>
HYPGEN_FN void put_at(Mask mask, Lanes<T> (&array)[N], Int position, const V& value) {
  for (std::size_t i = 0; i < N; ++i) {
    assign(both(mask, position == Int(static_cast<std::int32_t>(i))), array[i], value);
  }
}
template <class P, class V, std::enable_if_t<std::is_pointer_v<P>, int> = 0>
HYPGEN_FN void put_at(Mask mask, const P& array, std::int32_t position, const V& value) {
  assign(mask, array[position], value);
}

// Bit fields -------------------------------------------------------------------------------------------

template <std::size_t N>
HYPGEN_FN Word word_at(const Word (&words)[N], std::int32_t word) {
  return words[word];
}
template <std::size_t N>
HYPGEN_FN Word word_at(const Word (&words)[N], Int word) {
  if constexpr (N == 1) return words[0];
  const Word last(static_cast<std::uint32_t>(N - 1)), wanted = as<std::uint32_t>(word);
  const Int place = as<std::int32_t>(select_lanes<std::uint32_t>(wanted < last, wanted, last));
  return gather(words, place * Int(kLanes) + lane_numbers());
}

/// `bits::get` of each lane.
template <std::size_t N, class W, class S>
HYPGEN_FN Word get(const Word (&words)[N], W word, S shift, std::uint32_t width) {
  return (word_at(words, word) >> Word(as<std::uint32_t>(shift))) & Word(~0U >> (32 - width));
}

/// `bits::put` of the lanes of `mask`.
template <std::size_t N, class S>
HYPGEN_FN void put(Mask mask, Word (&words)[N], std::int32_t word, S shift, std::uint32_t width, Word field) {
  const Word place(as<std::uint32_t>(shift));
  assign(mask, words[word], (words[word] & ~(Word(~0U >> (32 - width)) << place)) | (field << place));
}
template <std::size_t N, class S>
HYPGEN_FN void put(Mask mask, Word (&words)[N], Int word, S shift, std::uint32_t width, Word field) {
  for (std::size_t i = 0; i < N; ++i) {
    const auto number = static_cast<std::int32_t>(i);
    put(both(mask, word == Int(number)), words, number, shift, width, field);
  }
}

/// A whole word of the lanes of `mask`.
template <std::size_t N, class W>
HYPGEN_FN void put_word(Mask mask, Word (&words)[N], W word, Word value) {
  put_at(mask, words, word, value);
}

/// A position over, and its rest from, a power of two.
template <std::int32_t kSize>
HYPGEN_FN std::int32_t over(std::int32_t position) {
  return position / kSize;
}
template <std::int32_t kSize>
HYPGEN_FN Int over(Int position) {
  return as<std::int32_t>(as<std::uint32_t>(position) >>
                          Word(static_cast<std::uint32_t>(__builtin_ctz(kSize))));
}
template <std::int32_t kSize>
HYPGEN_FN std::int32_t rest(std::int32_t position) {
  return position % kSize;
}
template <std::int32_t kSize>
HYPGEN_FN Int rest(Int position) {
  return as<std::int32_t>(as<std::uint32_t>(position) & Word(static_cast<std::uint32_t>(kSize - 1)));
}

}  // namespace hypgen::lanes
