// SPDX-License-Identifier: Apache-2.0
// Laws of counts: masses of 0, 1, 2, .. that follow from one another, searched from the lowest count up.
#pragma once

#include <cstdint>

#include "hypgen/core/config.hpp"
#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/random/word_thresholds.hpp"

namespace hypgen::dist {

/// The counts that a law is truncated to; without `limited` all of them.
struct Truncation {
  std::int32_t first = 0;
  std::int32_t last = 0;
  bool limited = false;
};

/// e^-mean, then each mass from the one before.
class PoissonMasses {
 public:
  HYPGEN_FN explicit PoissonMasses(float mean) {
    mean_ = mean > 0.0F ? static_cast<double>(mean < 690.0F ? mean : 690.0F) : 0.0;
    mass_ = math::detail::exp2_inside(mean_ * -1.4426950408889634);
  }

  HYPGEN_FN double mass() const { return mass_; }

  HYPGEN_FN void advance() {
    count_ = count_ + 1.0;
    mass_ = mass_ * (mean_ / count_);
  }

 private:
  double mean_;
  double mass_;
  double count_ = 0.0;
};

/// (1 - p)^n, then each mass from the one before; p is at most 1/2.
class BinomialMasses {
 public:
  HYPGEN_FN BinomialMasses(std::int32_t trials, double p) : trials_(trials), odds_(p / (1.0 - p)) {
    double base = 1.0 - p;
    for (std::int32_t left = trials; left > 0; left >>= 1) {
      if ((left & 1) != 0) mass_ = mass_ * base;
      base = base * base;
    }
  }

  HYPGEN_FN double mass() const { return mass_; }

  HYPGEN_FN void advance() {
    mass_ = (mass_ * ((trials_ - count_) / (count_ + 1.0))) * odds_;
    count_ = count_ + 1.0;
  }

 private:
  double trials_;
  double odds_;
  double mass_ = 1.0;
  double count_ = 0.0;
};

/// How many words give at most k, for k that does not fall.
template <class Masses>
class Reach {
 public:
  HYPGEN_FN Reach(Masses masses, Truncation truncation) : masses_(masses) {
    for (; count_ < truncation.first; ++count_) masses_.advance();
    if (!truncation.limited) return;
    total_ = 0.0;
    Masses ahead = masses_;
    for (std::int32_t k = count_; k <= truncation.last; ++k) {
      total_ = total_ + ahead.mass();
      ahead.advance();
    }
  }

  HYPGEN_FN std::uint64_t up_to(std::int32_t k) {
    for (; count_ <= k; ++count_) {
      sum_ = sum_ + masses_.mass();
      masses_.advance();
    }
    return words_of(sum_ / total_);
  }

 private:
  Masses masses_;
  std::int32_t count_ = 0;
  double sum_ = 0.0;
  double total_ = 1.0;
};

/// The first count of low .. high that the word does not pass; high takes what is left.
template <class Word, class Masses>
HYPGEN_FN std::int32_t count(Word word, Reach<Masses> reach, std::int32_t low, std::int32_t high) {
  std::int32_t k = low;
  while (k < high && word >= reach.up_to(k)) ++k;
  return k;
}

template <class Masses>
HYPGEN_FN double count_density(std::int32_t k, Reach<Masses> reach, std::int32_t low, std::int32_t high) {
  if (k < low || k > high) return 0.0;
  const std::uint64_t before = k == low ? 0 : reach.up_to(k - 1);
  return share((k == high ? kWords : reach.up_to(k)) - before);
}

template <class Word>
HYPGEN_FN std::int32_t poisson(Word word, float mean, Truncation truncation, std::int32_t low,
                               std::int32_t high) {
  return count(word, Reach<PoissonMasses>(PoissonMasses(mean), truncation), low, high);
}

HYPGEN_FN double poisson_density(std::int32_t k, float mean, Truncation truncation, std::int32_t low,
                                 std::int32_t high) {
  return count_density(k, Reach<PoissonMasses>(PoissonMasses(mean), truncation), low, high);
}

/// A binomial law with its search: of successes where they are the rarer outcome, else of failures.
struct Binomial {
  std::int32_t trials;
  std::int32_t low;
  std::int32_t high;
  bool failures;
  Reach<BinomialMasses> reach;

  HYPGEN_FN static Binomial of(std::int32_t trials, float probability, Truncation truncation,
                               std::int32_t low, std::int32_t high) {
    const double p = probability > 0.0F ? static_cast<double>(probability < 1.0F ? probability : 1.0F) : 0.0;
    const std::int32_t most = trials < high ? trials : high;
    if (!(p > 0.5)) {
      return {trials, low, most, false, Reach<BinomialMasses>(BinomialMasses(trials, p), truncation)};
    }
    const Truncation mirrored{trials - truncation.last, trials - truncation.first, truncation.limited};
    const Truncation used = truncation.limited ? mirrored : Truncation{};
    return {trials, trials - most, trials - low, true,
            Reach<BinomialMasses>(BinomialMasses(trials, 1.0 - p), used)};
  }
};

template <class Word>
HYPGEN_FN std::int32_t binomial(Word word, std::int32_t trials, float probability, Truncation truncation,
                                std::int32_t low, std::int32_t high) {
  if (trials <= low) return low;
  const Binomial law = Binomial::of(trials, probability, truncation, low, high);
  return law.failures ? trials - count(~word, law.reach, law.low, law.high)
                      : count(word, law.reach, law.low, law.high);
}

HYPGEN_FN double binomial_density(std::int32_t k, std::int32_t trials, float probability,
                                  Truncation truncation, std::int32_t low, std::int32_t high) {
  if (trials <= low) return k == low ? 1.0 : 0.0;
  const Binomial law = Binomial::of(trials, probability, truncation, low, high);
  return count_density(law.failures ? trials - k : k, law.reach, law.low, law.high);
}

}  // namespace hypgen::dist
