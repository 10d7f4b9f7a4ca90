// How a random word becomes a value, and the probability of each value: by inverse CDF over 2^32 words.
//
// Generated models draw and weigh by these. A density counts the words that give a value, so that sampler
// and filter agree to the last word even where a probability was clipped or rounded.
#pragma once

#include <cstdint>

#include "hypgen/config.hpp"
#include "hypgen/math.hpp"

namespace hypgen::dist {

/// The number of words there are.
inline constexpr std::uint64_t kWords = std::uint64_t{1} << 32;

/// The probability of `words` out of all words.
HYPGEN_FN double share(std::uint64_t words) { return static_cast<double>(words) * (1.0 / 4294967296.0); }

/// true with probability p.
HYPGEN_FN bool bernoulli(std::uint32_t word, float p) { return word < math::threshold(p); }

HYPGEN_FN double bernoulli_density(bool value, float p) {
  const std::uint64_t t = math::threshold(p);
  return share(value ? t : kWords - t);
}

/// One of 0 .. count - 1, each with the same probability.
HYPGEN_FN std::int32_t uniform(std::uint32_t word, std::int32_t count) {
  return static_cast<std::int32_t>((std::uint64_t{word} * static_cast<std::uint64_t>(count)) >> 32);
}

/// 1 where `word` >= `bound`, else 0: by the borrow of a difference, as compilers branch on comparisons and
/// processors cannot predict random words.
HYPGEN_FN std::int32_t reached(std::uint32_t word, std::uint32_t bound) {
  return 1 - static_cast<std::int32_t>((std::uint64_t{word} - std::uint64_t{bound}) >> 63);
}

/// `value`, one of 0 .. count - 1, with probability p, else uniformly one of the others.
HYPGEN_FN std::int32_t noisy(std::uint32_t word, std::int32_t value, float p, std::int32_t count) {
  const std::uint64_t t = math::threshold(p);
  if (word < t || count == 1) return value;
  const auto other =
      static_cast<std::int32_t>((word - t) * static_cast<std::uint64_t>(count - 1) / (kWords - t));
  return other < value ? other : other + 1;
}

HYPGEN_FN double noisy_density(bool is_value, float p, std::int32_t count) {
  if (count == 1) return 1.0;
  const std::uint64_t t = math::threshold(p);
  return is_value ? share(t) : share(kWords - t) / static_cast<double>(count - 1);
}

/// Adds up the words that the entries of a table equal to one value get, entry by entry.
class Masses {
 public:
  /// The next entry, whose probability is p.
  HYPGEN_FN void take(float p, bool is_value) {
    const std::uint64_t t = math::threshold(p);
    const std::uint64_t got = t < left_ ? t : left_;
    left_ -= got;
    if (is_value) words_ += got;
  }

  /// The last value, which gets what is left.
  HYPGEN_FN void take_rest(bool is_value) {
    if (is_value) words_ += left_;
    left_ = 0;
  }

  HYPGEN_FN double density() const { return share(words_); }

 private:
  std::uint64_t left_ = kWords;
  std::uint64_t words_ = 0;
};

}  // namespace hypgen::dist
