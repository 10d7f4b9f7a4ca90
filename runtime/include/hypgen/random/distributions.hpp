// SPDX-License-Identifier: Apache-2.0
// Values from random words, and the probability of each value: by inverse CDF over 2^32 words or, where
// probabilities may be rare, over 2^63 (fine_words.hpp).
//
// Generated models draw and weigh by these. A density counts the words that give a value, so that sampler
// and filter agree to the last word even where a probability was clipped or rounded. Samplers are templates
// over the word, which may also be an interval of words (enumerating_draws.hpp): they compare it, or
// ask for its `piece_of` equal pieces.
#pragma once

#include <cstdint>

#include "hypgen/core/config.hpp"
#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/random/continuous.hpp"
#include "hypgen/random/counts.hpp"
#include "hypgen/random/fine_words.hpp"
#include "hypgen/random/word_thresholds.hpp"

namespace hypgen::dist {

/// true with probability p.
template <class Word>
HYPGEN_FN bool bernoulli(Word word, float p) {
  return word < math::threshold(p);
}

HYPGEN_FN double bernoulli_density(bool value, float p) {
  const std::uint64_t t = math::threshold(p);
  return share(value ? t : kWords - t);
}

/// true with the probability of a mass.
template <class D>
HYPGEN_FN bool bernoulli(const FineWord<D>& word, std::uint64_t mass) {
  return word.below(mass);
}

HYPGEN_FN double bernoulli_density(bool value, std::uint64_t mass) {
  return share_of(value ? mass : kWhole - mass);
}

/// One of 0 .. count - 1, each with the same probability.
template <class Word>
HYPGEN_FN std::int32_t uniform(Word word, std::int32_t count) {
  return static_cast<std::int32_t>(piece_of(word, 0, static_cast<std::uint64_t>(count)));
}

/// One of low .. high, each with the same probability, or low if that lies above high; clamped into least ..
/// most.
template <class Word>
HYPGEN_FN std::int32_t uniform_int(Word word, std::int32_t low, std::int32_t high, std::int32_t least,
                                   std::int32_t most) {
  const std::int64_t count = high < low ? 1 : std::int64_t{high} - low + 1;
  const std::uint64_t position = piece_of(word, 0, static_cast<std::uint64_t>(count));
  const std::int64_t drawn = low + static_cast<std::int64_t>(position);
  return static_cast<std::int32_t>(drawn < least ? least : drawn > most ? most : drawn);
}

HYPGEN_FN double uniform_int_density(std::int32_t value, std::int32_t low, std::int32_t high,
                                     std::int32_t least, std::int32_t most) {
  const std::int64_t count = high < low ? 1 : std::int64_t{high} - low + 1;
  const std::int64_t end = low + count - 1;
  const std::int64_t from = value == least || value < low ? low : value;
  const std::int64_t to = value == most || value > end ? end : value;
  return from > to ? 0.0 : static_cast<double>(to - from + 1) / static_cast<double>(count);
}

/// 1 where `word` >= `bound`, else 0: by the borrow of a difference, as compilers branch on comparisons and
/// processors cannot predict random words.
HYPGEN_FN std::int32_t reached(std::uint32_t word, std::uint32_t bound) {
  return 1 - static_cast<std::int32_t>((std::uint64_t{word} - std::uint64_t{bound}) >> 63);
}
template <class Word>
HYPGEN_FN std::int32_t reached(Word word, std::uint32_t bound) {
  return word < bound ? 0 : 1;
}

/// `value`, one of 0 .. count - 1, with probability p, else uniformly one of the others.
template <class Word>
HYPGEN_FN std::int32_t noisy(Word word, std::int32_t value, float p, std::int32_t count) {
  const std::uint64_t t = math::threshold(p);
  if (word < t || count == 1) return value;
  const auto other = static_cast<std::int32_t>(piece_of(word, t, static_cast<std::uint64_t>(count - 1)));
  return other < value ? other : other + 1;
}

HYPGEN_FN double noisy_density(bool is_value, float p, std::int32_t count) {
  if (count == 1) return 1.0;
  const std::uint64_t t = math::threshold(p);
  return is_value ? share(t) : share(kWords - t) / static_cast<double>(count - 1);
}

/// The same with a mass. Whole words are split as above, while the others have enough of them.
template <class D>
HYPGEN_FN std::int32_t noisy(const FineWord<D>& word, std::int32_t value, std::uint64_t mass,
                             std::int32_t count) {
  if (count == 1) return value;
  if (count == 2) return word.below(mass) ? value : 1 - value;
  if (word.below(mass)) return value;
  const auto others = static_cast<std::uint64_t>(count - 1);
  const bool by_words = (mass & kLow) == 0 && kWhole - mass >= others << 45;
  const auto other = static_cast<std::int32_t>(by_words ? piece_of(word.word(), mass >> kLowBits, others)
                                                        : word.piece(Pieces(mass, others)));
  return other < value ? other : other + 1;
}

HYPGEN_FN double noisy_density(bool is_value, std::uint64_t mass, std::int32_t count) {
  if (count == 1) return 1.0;
  return is_value ? share_of(mass) : share_of(kWhole - mass) / static_cast<double>(count - 1);
}

/// Adds up the masses that the entries of a table equal to one value get, entry by entry.
class Masses {
 public:
  /// The next entry, with its probability or mass.
  HYPGEN_FN void take(float p, bool is_value) { take(math::mass(p), is_value); }
  HYPGEN_FN void take(std::uint64_t mass, bool is_value) {
    const std::uint64_t got = mass < left_ ? mass : left_;
    left_ -= got;
    if (is_value) sum_ += got;
  }

  /// The last value, which gets what is left.
  HYPGEN_FN void take_rest(bool is_value) {
    if (is_value) sum_ += left_;
    left_ = 0;
  }

  HYPGEN_FN double density() const { return share_of(sum_); }

 private:
  std::uint64_t left_ = kWhole;
  std::uint64_t sum_ = 0;
};

/// Adds up the weights of a draw's candidates.
class WeightSum {
 public:
  /// The next candidate: whether it is the likeliest so far.
  HYPGEN_FN bool add(float weight) {
    if (!(weight > 0.0F)) return false;
    sum_ = sum_ + static_cast<double>(weight);
    if (!(weight > largest_)) return false;
    largest_ = weight;
    return true;
  }

  HYPGEN_FN bool empty() const { return !(sum_ > 0.0); }

  /// The mass of a weight of 1: all weights get nearly all, the likeliest also what they leave.
  HYPGEN_FN double scale() const { return 9223372034707292160.0 / sum_; }

 private:
  double sum_ = 0.0;
  float largest_ = 0.0F;
};

/// Goes through a draw's candidates, each with its mass.
class WeightWalk {
 public:
  HYPGEN_FN explicit WeightWalk(const WeightSum& sum) : scale_(sum.scale()) {}

  /// The next candidate: whether it can be drawn at all.
  HYPGEN_FN bool add(float weight) {
    if (!(weight > 0.0F)) return false;
    before_ = until_;
    const double scaled = static_cast<double>(weight) * scale_;
    if (scaled < 9223372036854775808.0) until_ = up_to(until_, static_cast<std::uint64_t>(scaled));
    return true;
  }

  HYPGEN_FN std::uint64_t before() const { return before_; }
  HYPGEN_FN std::uint64_t until() const { return until_; }

 private:
  double scale_;
  std::uint64_t before_ = 0;
  std::uint64_t until_ = 0;
};

}  // namespace hypgen::dist
