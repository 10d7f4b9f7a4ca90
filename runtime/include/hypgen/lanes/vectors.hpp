// SPDX-License-Identifier: Apache-2.0
// Values of many scenarios side by side, a lane each, in vector registers.
//
// Every operation gives each lane the bits that the same operation gives a scalar. GCC's vector types make the
// instructions, so one text serves each width. What `assign` is told to leave alone keeps its value.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include "hypgen/core/config.hpp"

namespace hypgen::lanes {

/// The bytes of a vector register.
#if defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512VL__) && defined(__AVX512BW__)
#define HYPGEN_LANES_AVX512
inline constexpr int kBytes = 64;
#else
inline constexpr int kBytes = 32;
#endif

/// How many scenarios lie side by side: one 32-bit value of each fills a register.
inline constexpr int kLanes = kBytes / 4;

template <class T, int kSize>
struct VectorOf {
  typedef T type __attribute__((vector_size(kSize)));
};
template <class T>
using Full = typename VectorOf<T, kBytes>::type;
/// Half of the lanes, of 32-bit values.
template <class T>
using Half = typename VectorOf<T, kBytes / 2>::type;

using FloatHalf = Half<float>;
using IntHalf = Half<std::int32_t>;
using WordHalf = Half<std::uint32_t>;
using Doubles = Full<double>;
using Longs = Full<std::int64_t>;
using Masses = Full<std::uint64_t>;

/// Both halves of the lanes as one vector, and the halves of one.
template <class T>
HYPGEN_FN Full<T> joined(Half<T> low, Half<T> high) {
  Full<T> both;
  std::memcpy(&both, &low, sizeof low);
  std::memcpy(reinterpret_cast<char*>(&both) + sizeof low, &high, sizeof high);
  return both;
}
template <int part, class T>
HYPGEN_FN Half<T> half(const Full<T>& both) {
  Half<T> some;
  std::memcpy(&some, reinterpret_cast<const char*>(&both) + part * sizeof some, sizeof some);
  return some;
}

/// A value of each lane: 32-bit values in one register, 64-bit ones in two.
template <class T>
struct Lanes;

/// A truth of each lane: all bits of its number, or none.
template <>
struct Lanes<bool> {
  Full<std::int32_t> v{};

  Lanes() = default;
  HYPGEN_FN Lanes(bool value) : v(std::int32_t{value ? -1 : 0} - Full<std::int32_t>{}) {}
  HYPGEN_FN explicit Lanes(Full<std::int32_t> bits) : v(bits) {}

  HYPGEN_FN Longs wide(int part) const {
    return __builtin_convertvector(part == 0 ? half<0, std::int32_t>(v) : half<1, std::int32_t>(v), Longs);
  }

  friend HYPGEN_FN Lanes operator!(Lanes a) { return Lanes(~a.v); }
  friend HYPGEN_FN Lanes operator==(Lanes a, Lanes b) { return Lanes(~(a.v ^ b.v)); }
  friend HYPGEN_FN Lanes operator!=(Lanes a, Lanes b) { return Lanes(a.v ^ b.v); }
};
using Mask = Lanes<bool>;

HYPGEN_FN Mask both(Mask a, Mask b) { return Mask(a.v & b.v); }
HYPGEN_FN Mask either(Mask a, Mask b) { return Mask(a.v | b.v); }
HYPGEN_FN Mask without(Mask a, Mask b) { return Mask(a.v & ~b.v); }
HYPGEN_FN bool both(bool a, bool b) { return a && b; }
HYPGEN_FN bool either(bool a, bool b) { return a || b; }

/// The lanes of a mask as bits.
HYPGEN_FN std::uint32_t bits_of(Mask mask) {
#if defined(HYPGEN_LANES_AVX512)
  return _mm512_movepi32_mask(reinterpret_cast<__m512i>(mask.v));
#elif defined(__AVX2__)
  return static_cast<std::uint32_t>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask.v)));
#else
  std::uint32_t bits = 0;
  for (int i = 0; i < kLanes; ++i) bits |= (mask.v[i] != 0 ? 1U : 0U) << i;
  return bits;
#endif
}
HYPGEN_FN bool any(Mask mask) { return bits_of(mask) != 0; }

template <class T>
struct Narrow {
  Full<T> v{};

  HYPGEN_FN T operator[](int lane) const { return v[lane]; }
  HYPGEN_FN void set(int lane, T value) { v[lane] = value; }
};

#define HYPGEN_LANES_NARROW(sign) \
  friend HYPGEN_FN Lanes operator sign(Lanes a, Lanes b) { return Lanes(a.v sign b.v); }
#define HYPGEN_LANES_COMPARE(sign) \
  friend HYPGEN_FN Mask operator sign(Lanes a, Lanes b) { return Mask(a.v sign b.v); }

template <>
struct Lanes<float> : Narrow<float> {
  Lanes() = default;
  HYPGEN_FN Lanes(float value) { v = value - Full<float>{}; }
  HYPGEN_FN explicit Lanes(Full<float> value) { v = value; }

  HYPGEN_LANES_NARROW(+)
  HYPGEN_LANES_NARROW(-)
  HYPGEN_LANES_NARROW(*)
  HYPGEN_LANES_NARROW(/)
  HYPGEN_LANES_COMPARE(==)
  HYPGEN_LANES_COMPARE(!=)
  HYPGEN_LANES_COMPARE(<)
  HYPGEN_LANES_COMPARE(<=)
  HYPGEN_LANES_COMPARE(>)
  HYPGEN_LANES_COMPARE(>=)
  friend HYPGEN_FN Lanes operator-(Lanes a) { return Lanes(-a.v); }

  HYPGEN_FN Doubles wide(int part) const {
    return __builtin_convertvector(part == 0 ? half<0, float>(v) : half<1, float>(v), Doubles);
  }
};

template <>
struct Lanes<std::uint32_t> : Narrow<std::uint32_t> {
  Lanes() = default;
  HYPGEN_FN Lanes(std::uint32_t value) { v = value - Full<std::uint32_t>{}; }
  Lanes(std::uint64_t value) = delete;  // a number of words may be one more than a word holds
  HYPGEN_FN Lanes(std::int32_t value) : Lanes(static_cast<std::uint32_t>(value)) {}
  HYPGEN_FN explicit Lanes(Full<std::uint32_t> value) { v = value; }

  HYPGEN_LANES_NARROW(+)
  HYPGEN_LANES_NARROW(-)
  HYPGEN_LANES_NARROW(*)
  HYPGEN_LANES_NARROW(&)
  HYPGEN_LANES_NARROW(|)
  HYPGEN_LANES_NARROW(^)
  HYPGEN_LANES_NARROW(<<)
  HYPGEN_LANES_NARROW(>>)
  HYPGEN_LANES_COMPARE(==)
  HYPGEN_LANES_COMPARE(!=)
  HYPGEN_LANES_COMPARE(<)
  HYPGEN_LANES_COMPARE(<=)
  HYPGEN_LANES_COMPARE(>)
  HYPGEN_LANES_COMPARE(>=)
  friend HYPGEN_FN Lanes operator~(Lanes a) { return Lanes(~a.v); }
  friend HYPGEN_FN Lanes operator/(Lanes a, std::uint32_t b) {
    const double part = 1.0 / static_cast<double>(b);
    const auto quotient = [part](Doubles x) {
      // 2^52 + 2^51: the sum's last bits are the whole, rounded down, also where the difference is below 0.
      const Doubles whole = (x + 0.5) * part - 0.5 + 6755399441055744.0;
      return __builtin_convertvector(reinterpret_cast<Masses>(whole), WordHalf);
    };
    return Lanes(joined<std::uint32_t>(quotient(a.wide(0)), quotient(a.wide(1))));
  }
  friend HYPGEN_FN Lanes operator%(Lanes a, std::uint32_t b) { return a - Lanes(b) * (a / b); }

  // Exact: through signed numbers, which every processor converts.
  HYPGEN_FN Doubles wide(int part) const {
    const Full<std::int32_t> shifted = reinterpret_cast<Full<std::int32_t>>(v ^ 0x80000000U);
    const IntHalf some = part == 0 ? half<0, std::int32_t>(shifted) : half<1, std::int32_t>(shifted);
    return __builtin_convertvector(some, Doubles) + 2147483648.0;
  }
};

template <>
struct Lanes<std::int32_t> : Narrow<std::int32_t> {
  Lanes() = default;
  HYPGEN_FN Lanes(std::int32_t value) { v = value - Full<std::int32_t>{}; }
  HYPGEN_FN explicit Lanes(Full<std::int32_t> value) { v = value; }

  // As unsigned numbers, whose lanes may overflow where they count for nothing.
  friend HYPGEN_FN Lanes operator+(Lanes a, Lanes b) { return Lanes(signed_(a.words() + b.words())); }
  friend HYPGEN_FN Lanes operator-(Lanes a, Lanes b) { return Lanes(signed_(a.words() - b.words())); }
  friend HYPGEN_FN Lanes operator*(Lanes a, Lanes b) { return Lanes(signed_(a.words() * b.words())); }
  friend HYPGEN_FN Lanes operator-(Lanes a) { return Lanes(signed_(-a.words())); }
  HYPGEN_LANES_COMPARE(==)
  HYPGEN_LANES_COMPARE(!=)
  HYPGEN_LANES_COMPARE(<)
  HYPGEN_LANES_COMPARE(<=)
  HYPGEN_LANES_COMPARE(>)
  HYPGEN_LANES_COMPARE(>=)

  // By doubles, whose quotients of such numbers are never rounded up to a whole number.
  friend HYPGEN_FN Lanes operator/(Lanes a, Lanes b) {
    return Lanes(joined<std::int32_t>(__builtin_convertvector(a.wide(0) / b.wide(0), IntHalf),
                                      __builtin_convertvector(a.wide(1) / b.wide(1), IntHalf)));
  }
  friend HYPGEN_FN Lanes operator%(Lanes a, Lanes b) { return a - b * (a / b); }
  // Half of one farther from 0: rounding cannot take the product beyond a whole number.
  friend HYPGEN_FN Lanes operator/(Lanes a, std::int32_t b) {
    const double part = 1.0 / static_cast<double>(b);
    const auto quotient = [part](Doubles x) {
      return __builtin_convertvector((x + (x < 0.0 ? -0.5 - Doubles{} : 0.5 - Doubles{})) * part, IntHalf);
    };
    return Lanes(joined<std::int32_t>(quotient(a.wide(0)), quotient(a.wide(1))));
  }
  friend HYPGEN_FN Lanes operator%(Lanes a, std::int32_t b) { return a - Lanes(b) * (a / b); }

  HYPGEN_FN Full<std::uint32_t> words() const { return reinterpret_cast<Full<std::uint32_t>>(v); }
  HYPGEN_FN Doubles wide(int part) const {
    return __builtin_convertvector(part == 0 ? half<0, std::int32_t>(v) : half<1, std::int32_t>(v), Doubles);
  }

 private:
  HYPGEN_FN static Full<std::int32_t> signed_(Full<std::uint32_t> words) {
    return reinterpret_cast<Full<std::int32_t>>(words);
  }
};

#undef HYPGEN_LANES_NARROW
#undef HYPGEN_LANES_COMPARE
#define HYPGEN_LANES_WIDE(sign)                            \
  friend HYPGEN_FN Lanes operator sign(Lanes a, Lanes b) { \
    return Lanes(a.low sign b.low, a.high sign b.high);    \
  }
#define HYPGEN_LANES_COMPARE(sign)                        \
  friend HYPGEN_FN Mask operator sign(Lanes a, Lanes b) { \
    return narrow(a.low sign b.low, a.high sign b.high);  \
  }

/// Masses as doubles, rounded once: through halves, each of which a double holds.
HYPGEN_FN Doubles to_doubles(Masses x) {
#if defined(HYPGEN_LANES_AVX512)
  return __builtin_convertvector(x, Doubles);
#else
  const Masses upper = (x >> 32) | 0x4330000000000000U, lower = (x & 0xFFFFFFFFU) | 0x4330000000000000U;
  return (reinterpret_cast<Doubles>(upper) - 4503599627370496.0) * 4294967296.0 +
         (reinterpret_cast<Doubles>(lower) - 4503599627370496.0);
#endif
}

HYPGEN_FN Mask narrow(Longs low, Longs high) {
  return Mask(
      joined<std::int32_t>(__builtin_convertvector(low, IntHalf), __builtin_convertvector(high, IntHalf)));
}

template <class T>
struct Wide {
  Full<T> low{};
  Full<T> high{};

  HYPGEN_FN T operator[](int lane) const { return lane < kLanes / 2 ? low[lane] : high[lane - kLanes / 2]; }
  HYPGEN_FN void set(int lane, T value) {
    if (lane < kLanes / 2) {
      low[lane] = value;
    } else {
      high[lane - kLanes / 2] = value;
    }
  }
};

template <>
struct Lanes<double> : Wide<double> {
  Lanes() = default;
  HYPGEN_FN Lanes(double value) { low = high = value - Doubles{}; }
  HYPGEN_FN Lanes(Doubles first, Doubles second) {
    low = first;
    high = second;
  }

  HYPGEN_LANES_WIDE(+)
  HYPGEN_LANES_WIDE(-)
  HYPGEN_LANES_WIDE(*)
  HYPGEN_LANES_WIDE(/)
  HYPGEN_LANES_COMPARE(==)
  HYPGEN_LANES_COMPARE(!=)
  HYPGEN_LANES_COMPARE(<)
  HYPGEN_LANES_COMPARE(<=)
  HYPGEN_LANES_COMPARE(>)
  HYPGEN_LANES_COMPARE(>=)
  friend HYPGEN_FN Lanes operator-(Lanes a) { return {-a.low, -a.high}; }

  HYPGEN_FN Doubles wide(int part) const { return part == 0 ? low : high; }
};

template <>
struct Lanes<std::uint64_t> : Wide<std::uint64_t> {
  Lanes() = default;
  HYPGEN_FN Lanes(std::uint64_t value) { low = high = value - Masses{}; }
  HYPGEN_FN Lanes(Masses first, Masses second) {
    low = first;
    high = second;
  }

  HYPGEN_LANES_WIDE(+)
  HYPGEN_LANES_WIDE(-)
  HYPGEN_LANES_WIDE(*)
  HYPGEN_LANES_WIDE(&)
  HYPGEN_LANES_WIDE(|)
  HYPGEN_LANES_WIDE(^)
  HYPGEN_LANES_WIDE(<<)
  HYPGEN_LANES_WIDE(>>)
  HYPGEN_LANES_COMPARE(==)
  HYPGEN_LANES_COMPARE(!=)
  HYPGEN_LANES_COMPARE(<)
  HYPGEN_LANES_COMPARE(<=)
  HYPGEN_LANES_COMPARE(>)
  HYPGEN_LANES_COMPARE(>=)
  HYPGEN_FN Doubles wide(int part) const { return to_doubles(part == 0 ? low : high); }

  // No processor divides such vectors.
  HYPGEN_LANES_WIDE(/)
  HYPGEN_LANES_WIDE(%)
};

#undef HYPGEN_LANES_WIDE
#undef HYPGEN_LANES_COMPARE

using Float = Lanes<float>;
using Int = Lanes<std::int32_t>;
using Word = Lanes<std::uint32_t>;
using Double = Lanes<double>;

/// The type of a value's lanes: of a number's, or of what has lanes.
template <class T>
struct Element {
  using type = T;
};
template <class T>
struct Element<Lanes<T>> {
  using type = T;
};
template <class T>
inline constexpr bool kHasLanes = !std::is_same_v<typename Element<T>::type, T>;

// Choices ----------------------------------------------------------------------------------------------

template <class V, class M>
HYPGEN_FN V chosen(M mask, V a, V b) {
  return mask ? a : b;
}

template <class T>
HYPGEN_FN Lanes<T> select_lanes(Mask mask, const Lanes<T>& a, const Lanes<T>& b) {
  if constexpr (sizeof(T) == 8) {
    return Lanes<T>(mask.wide(0) ? a.low : b.low, mask.wide(1) ? a.high : b.high);
  } else if constexpr (std::is_same_v<T, bool>) {
    return Mask((mask.v & a.v) | (~mask.v & b.v));
  } else {
    return Lanes<T>(mask.v ? a.v : b.v);
  }
}

/// `condition ? a : b` in each lane.
template <class A, class B>
HYPGEN_FN auto select(Mask condition, const A& a, const B& b) {
  using T = typename Element<std::conditional_t<kHasLanes<A>, A, B>>::type;
  return select_lanes<T>(condition, Lanes<T>(a), Lanes<T>(b));
}
template <class A, class B>
HYPGEN_FN auto select(bool condition, const A& a, const B& b) {
  using T = std::conditional_t<kHasLanes<A>, A, B>;
  return condition ? T(a) : T(b);
}

/// `value++` or `value--` in the lanes of `mask`: what it was before.
HYPGEN_FN Lanes<std::int32_t> stepped(Mask mask, Lanes<std::int32_t>& value, std::int32_t by) {
  const Lanes<std::int32_t> before = value;
  value = select_lanes<std::int32_t>(mask, before + by, before);
  return before;
}

/// Gives the lanes of `mask` a new value.
template <class T, class V>
HYPGEN_FN void assign(Mask mask, Lanes<T>& target, const V& value) {
  target = select_lanes<T>(mask, Lanes<T>(value), target);
}

/// What a model's structs of words are assigned by.
template <std::size_t N>
HYPGEN_FN void assign_words(Mask mask, Word (&target)[N], const Word (&value)[N]) {
  for (std::size_t i = 0; i < N; ++i) assign(mask, target[i], value[i]);
}

// Conversions ------------------------------------------------------------------------------------------

/// `static_cast<To>` of a number, or of each lane.
template <class To, class From, std::enable_if_t<!kHasLanes<From>, int> = 0>
HYPGEN_FN To as(From value) {
  return static_cast<To>(value);
}
template <class To, class From>
HYPGEN_FN Lanes<To> as(const Lanes<From>& value) {
  if constexpr (std::is_same_v<To, From>) {
    return value;
  } else if constexpr (std::is_same_v<To, bool>) {
    return value != Lanes<From>(From{});
  } else if constexpr (std::is_same_v<From, bool>) {
    return as<To>(Int(value.v & 1));
  } else if constexpr (std::is_same_v<To, double>) {
    return Double(value.wide(0), value.wide(1));
  } else if constexpr (sizeof(To) == 4 && sizeof(From) == 4) {
    if constexpr (std::is_integral_v<To> && std::is_integral_v<From>) {
      return Lanes<To>(reinterpret_cast<Full<To>>(value.v));
    } else {
      static_assert(std::is_same_v<From, std::int32_t> || std::is_same_v<To, std::int32_t>);
      return Lanes<To>(__builtin_convertvector(value.v, Full<To>));
    }
  } else if constexpr (std::is_same_v<From, std::int32_t>) {
    return Lanes<To>(__builtin_convertvector(half<0, From>(value.v), Full<To>),
                     __builtin_convertvector(half<1, From>(value.v), Full<To>));
  } else if constexpr (std::is_same_v<From, std::uint32_t>) {
    return Lanes<To>(__builtin_convertvector(half<0, From>(value.v), Full<To>),
                     __builtin_convertvector(half<1, From>(value.v), Full<To>));
  } else if constexpr (sizeof(To) == 8) {
    return Lanes<To>(__builtin_convertvector(value.low, Full<To>),
                     __builtin_convertvector(value.high, Full<To>));
  } else {
    return Lanes<To>(joined<To>(__builtin_convertvector(value.low, Half<To>),
                                __builtin_convertvector(value.high, Half<To>)));
  }
}

HYPGEN_FN Float from_bits(Word bits) { return Float(reinterpret_cast<Full<float>>(bits.v)); }
HYPGEN_FN Word to_bits(Float x) { return Word(reinterpret_cast<Full<std::uint32_t>>(x.v)); }

/// The lanes' numbers.
HYPGEN_FN Int lane_numbers() {
  Int numbers;
  for (int i = 0; i < kLanes; ++i) numbers.set(i, i);
  return numbers;
}

}  // namespace hypgen::lanes
