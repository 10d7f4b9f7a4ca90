// SPDX-License-Identifier: Apache-2.0
// The draws of many scenarios, a lane each, and values from their words: the same as hypgen/random gives.
#pragma once

#include <cstdint>

#include "hypgen/belief/posterior.hpp"
#include "hypgen/lanes/functions.hpp"
#include "hypgen/lanes/tables.hpp"
#include "hypgen/random/counts.hpp"
#include "hypgen/random/distributions.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen::lanes {

/// The upper and lower words of products.
struct Product {
  Word high;
  Word low;
};
HYPGEN_FN Product multiplied(Word a, Word b) {
#if defined(HYPGEN_LANES_AVX512)
  const auto x = reinterpret_cast<__m512i>(a.v), y = reinterpret_cast<__m512i>(b.v);
  const __m512i even = _mm512_mul_epu32(x, y);
  const __m512i odd = _mm512_mul_epu32(_mm512_srli_epi64(x, 32), _mm512_srli_epi64(y, 32));
  const __m512i high = _mm512_mask_blend_epi32(0xAAAA, _mm512_srli_epi64(even, 32), odd);
  return {Word(reinterpret_cast<Full<std::uint32_t>>(high)), a * b};
#elif defined(__AVX2__)
  const auto x = reinterpret_cast<__m256i>(a.v), y = reinterpret_cast<__m256i>(b.v);
  const __m256i even = _mm256_mul_epu32(x, y);
  const __m256i odd = _mm256_mul_epu32(_mm256_srli_epi64(x, 32), _mm256_srli_epi64(y, 32));
  const __m256i high = _mm256_blend_epi32(_mm256_srli_epi64(even, 32), odd, 0xAA);
  return {Word(reinterpret_cast<Full<std::uint32_t>>(high)), a * b};
#else
  Product product;
  for (int i = 0; i < kLanes; ++i) {
    const std::uint64_t both = std::uint64_t{a[i]} * b[i];
    product.high.set(i, static_cast<std::uint32_t>(both >> 32));
    product.low.set(i, static_cast<std::uint32_t>(both));
  }
  return product;
#endif
}

/// Philox4x32-10 of each lane's counter.
HYPGEN_FN void philox(StreamKey key, Word (&words)[4]) {
  for (int round = 0; round < 10; ++round) {
    const Product first = multiplied(words[0], Word(0xD2511F53U));
    const Product second = multiplied(words[2], Word(0xCD9E8D57U));
    words[0] = second.high ^ words[1] ^ Word(key.key0);
    words[1] = second.low;
    words[2] = first.high ^ words[3] ^ Word(key.key1);
    words[3] = first.low;
    key.key0 += 0x9E3779B9U;
    key.key1 += 0xBB67AE85U;
  }
}

/// The draws of a step of each lane's scenario.
class Draws {
 public:
  HYPGEN_FN Draws(StreamKey key, Word scenario, Word step) : key_(key), scenario_(scenario), step_(step) {}

  HYPGEN_FN Word word(std::uint32_t site, std::int32_t index) {
    const auto block = static_cast<std::uint32_t>(index) / 4;
    if (!cached_ || site != site_ || block != block_) {
      make(words_, site, Word(block));
      site_ = site;
      block_ = block;
      cached_ = true;
    }
    return words_[static_cast<std::uint32_t>(index) % 4];
  }

  HYPGEN_FN Word word(std::uint32_t site, Int index) const {
    const Word place = as<std::uint32_t>(index);
    Word words[4];
    make(words, site, place >> 2U);
    const Word rest = place & 3U;
    Word found = words[0];
    for (std::uint32_t i = 1; i < 4; ++i) assign(rest == Word(i), found, words[i]);
    return found;
  }

  /// One lane's scenario, for what few lanes need.
  HYPGEN_FN PhiloxDraws one(int lane) const { return PhiloxDraws(key_, scenario_[lane], step_[lane]); }

 private:
  HYPGEN_FN void make(Word (&words)[4], std::uint32_t site, Word block) const {
    words[0] = scenario_;
    words[1] = step_;
    words[2] = Word(site);
    words[3] = block;
    philox(key_, words);
  }

  StreamKey key_;
  Word scenario_;
  Word step_;
  std::uint32_t site_ = 0;
  std::uint32_t block_ = 0;
  bool cached_ = false;
  Word words_[4];
};

/// Whether words are below numbers of words in 0 .. 2^32, which are doubles.
HYPGEN_FN Mask is_below(Word word, Double limit) { return as<double>(word) < limit; }

/// Comparisons of words with numbers of words.
HYPGEN_FN Mask operator<(Word word, std::uint64_t limit) {
  return is_below(word, Double(static_cast<double>(limit)));
}
HYPGEN_FN Mask operator<(Word word, Lanes<std::uint64_t> limit) { return is_below(word, as<double>(limit)); }

/// The threshold of a probability; what is no number or below 0 gives a limit that no word is below.
HYPGEN_FN Double threshold(Float p) { return floor(as<double>(p) * Double(4294967296.0)); }

}  // namespace hypgen::lanes

namespace hypgen::dist {

using lanes::Double;
using lanes::Float;
using lanes::Int;
using lanes::Mask;
using lanes::Word;

HYPGEN_FN Mask bernoulli(Word word, Float p) { return lanes::is_below(word, lanes::threshold(p)); }

HYPGEN_FN Mask bernoulli(Word word, float p) { return bernoulli(word, Float(p)); }

HYPGEN_FN Int uniform(Word word, Int count) {
  return lanes::as<std::int32_t>(lanes::multiplied(word, lanes::as<std::uint32_t>(count)).high);
}

HYPGEN_FN Int uniform(Word word, std::int32_t count) { return uniform(word, Int(count)); }

HYPGEN_FN Int reached(Word word, std::uint32_t bound) { return lanes::as<std::int32_t>(word >= Word(bound)); }

HYPGEN_FN Int uniform_int(Word word, Int low, Int high, Int least, Int most) {
  return lanes::each_lane<std::int32_t>([](std::uint32_t w, std::int32_t a, std::int32_t b, std::int32_t c,
                                           std::int32_t d) { return uniform_int(w, a, b, c, d); },
                                        word, low, high, least, most);
}

HYPGEN_FN Int uniform_int(Word word, std::int32_t low, std::int32_t high, std::int32_t least,
                          std::int32_t most) {
  return uniform_int(word, Int(low), Int(high), Int(least), Int(most));
}

HYPGEN_FN Int poisson(Word word, Float mean, Truncation truncation, std::int32_t low, std::int32_t high) {
  const auto one = [=](std::uint32_t w, float m) { return poisson(w, m, truncation, low, high); };
  return lanes::each_lane<std::int32_t>(one, word, mean);
}
HYPGEN_FN Int poisson(Word word, float mean, Truncation truncation, std::int32_t low, std::int32_t high) {
  return poisson(word, Float(mean), truncation, low, high);
}

HYPGEN_FN Int binomial(Word word, Int trials, Float p, Truncation truncation, std::int32_t low,
                       std::int32_t high) {
  const auto one = [=](std::uint32_t w, std::int32_t n, float q) {
    return binomial(w, n, q, truncation, low, high);
  };
  return lanes::each_lane<std::int32_t>(one, word, trials, p);
}
HYPGEN_FN Int binomial(Word word, std::int32_t trials, float p, Truncation truncation, std::int32_t low,
                       std::int32_t high) {
  return binomial(word, Int(trials), Float(p), truncation, low, high);
}

HYPGEN_FN Int noisy(Word word, Int value, Float p, std::int32_t count) {
  return lanes::each_lane<std::int32_t>(
      [count](std::uint32_t w, std::int32_t v, float q) { return noisy(w, v, q, count); }, word, value, p);
}
HYPGEN_FN Int noisy(Word word, std::int32_t value, float p, std::int32_t count) {
  return noisy(word, Int(value), Float(p), count);
}
HYPGEN_FN Int noisy(Word word, Int value, float p, std::int32_t count) {
  return noisy(word, value, Float(p), count);
}

/// A draw with a second word, made lane by lane where a lane's word ties.
struct FineLanes {
  lanes::Draws* draws;
  std::uint32_t site;
  Int index;
  Word first;

  HYPGEN_FN Mask below(lanes::Lanes<std::uint64_t> mass) const {
    const Double high = lanes::as<double>(mass >> lanes::Lanes<std::uint64_t>(kLowBits));
    Mask found = lanes::is_below(first, high);
    const Mask ties = both(lanes::as<double>(first) == high,
                           (mass & lanes::Lanes<std::uint64_t>(kLow)) != lanes::Lanes<std::uint64_t>(0));
    if (HYPGEN_RARELY(any(ties))) {
      for (int i = 0; i < lanes::kLanes; ++i) {
        if (ties.v[i] == 0) continue;
        PhiloxDraws own = draws->one(i);
        const FineWord<PhiloxDraws> word(own, site, static_cast<std::uint32_t>(index[i]));
        found.v[i] = word.below(mass[i]) ? -1 : 0;
      }
    }
    return found;
  }
};
HYPGEN_FN FineLanes fine(lanes::Draws& draws, std::uint32_t site, std::int32_t index) {
  return {&draws, site, Int(index), draws.word(site, index)};
}
HYPGEN_FN FineLanes fine(lanes::Draws& draws, std::uint32_t site, std::uint32_t index) {
  return fine(draws, site, static_cast<std::int32_t>(index));
}
HYPGEN_FN FineLanes fine(lanes::Draws& draws, std::uint32_t site, Int index) {
  return {&draws, site, index, draws.word(site, index)};
}
HYPGEN_FN Mask bernoulli(const FineLanes& word, lanes::Lanes<std::uint64_t> mass) { return word.below(mass); }
HYPGEN_FN Mask bernoulli(const FineLanes& word, std::uint64_t mass) { return word.below(mass); }

HYPGEN_FN Int noisy(const FineLanes& word, Int value, lanes::Lanes<std::uint64_t> mass, std::int32_t count) {
  Int found;
  for (int i = 0; i < lanes::kLanes; ++i) {
    PhiloxDraws own = word.draws->one(i);
    const FineWord<PhiloxDraws> one(own, word.site, static_cast<std::uint32_t>(word.index[i]));
    found.set(i, noisy(one, value[i], mass[i], count));
  }
  return found;
}
HYPGEN_FN Int noisy(const FineLanes& word, std::int32_t value, std::uint64_t mass, std::int32_t count) {
  return noisy(word, Int(value), lanes::Bits(mass), count);
}
HYPGEN_FN lanes::Bits mass(Float p) { return math::mass(p); }
HYPGEN_FN lanes::Bits mass(Float p, Float complement) {
  const lanes::Bits rare = lanes::Bits(kWhole) - math::mass(complement);
  return select(complement < Float(0.001953125F), rare, math::mass(p));
}

HYPGEN_FN lanes::Bits up_to(lanes::Bits until, lanes::Bits mass) {
  const lanes::Bits left = lanes::Bits(kWhole) - until;
  return until + select(mass < left, mass, left);
}

/// The likelihoods of values of tables, as Masses computes them.
class MassesLanes {
 public:
  HYPGEN_FN void take(Mask on, Float p, Mask is_value) { take(on, math::mass(p), is_value); }
  HYPGEN_FN void take(Mask on, float p, Mask is_value) { take(on, Float(p), is_value); }
  HYPGEN_FN void take(Mask on, std::uint64_t mass, Mask is_value) {
    take(on, lanes::Lanes<std::uint64_t>(mass), is_value);
  }
  HYPGEN_FN void take(Mask on, lanes::Lanes<std::uint64_t> mass, Mask is_value) {
    const lanes::Lanes<std::uint64_t> got = select(mass < left_, mass, left_);
    lanes::assign(on, left_, left_ - got);
    lanes::assign(both(on, is_value), sum_, sum_ + got);
  }
  HYPGEN_FN void take_rest(Mask on, Mask is_value) {
    lanes::assign(both(on, is_value), sum_, sum_ + left_);
    lanes::assign(on, left_, lanes::Lanes<std::uint64_t>(0));
  }
  HYPGEN_FN Double density() const {
    return lanes::as<double>(sum_) * Double(1.08420217248550443400745280086994171142578125e-19);
  }

 private:
  lanes::Lanes<std::uint64_t> left_{kWhole};
  lanes::Lanes<std::uint64_t> sum_{0};
};

struct NormalLanes {
  Float mean;
  Float deviation;

  HYPGEN_FN Float draw(Word word) const {
    return mean + deviation * lanes::as<float>(lanes::normal_of_word(word));
  }
  HYPGEN_FN Float quantile(Word word) const {
    const Word rising = select(word < Word(0x80000000U), word, word ^ 0x7FFFFFFFU);
    return mean + math::abs(deviation) * lanes::as<float>(lanes::normal_of_word(rising));
  }
  HYPGEN_FN Double below(Double x) const {
    return lanes::normal_cdf((x - lanes::as<double>(mean)) / lanes::fabs(lanes::as<double>(deviation)));
  }
};

struct UniformLanes {
  Float low;
  Float high;

  HYPGEN_FN Float draw(Word word) const {
    const Double unit = (lanes::as<double>(word) + Double(0.5)) * Double(2.3283064365386963e-10);
    return math::min(low + (high - low) * lanes::as<float>(unit), high);
  }
};

/// Its functions are those of scalars, lane by lane.
class ExponentialLanes {
 public:
  HYPGEN_FN explicit ExponentialLanes(Float mean) : mean_(mean) {}

  HYPGEN_FN Float draw(Word word) const {
    return lanes::each_lane<float>([](float m, std::uint32_t w) { return Exponential(m).draw(w); }, mean_,
                                   word);
  }
  HYPGEN_FN Float quantile(Word word) const { return draw(~word); }
  HYPGEN_FN Double below(Double x) const {
    return lanes::each_lane<double>([](float m, double y) { return Exponential(m).below(y); }, mean_, x);
  }

 private:
  Float mean_;
};

/// `Bins` of a law, each lane with its own.
template <class Law>
class BinsLanes {
 public:
  HYPGEN_FN BinsLanes(Law law, Float low, Float high, std::int32_t count)
      : law_(law), low_(lanes::as<double>(low)), width_(lanes::as<double>(high) - low_), count_(count) {
    width_ = lanes::pick(lanes::above(width_, 0.0), width_, Double(0.0));
  }

  HYPGEN_FN Int draw(Word word) const {
    const double most = count_ - 1;
    const Double words = lanes::as<double>(word);
    const Double place = (lanes::as<double>(law_.quantile(word)) - low_) / width_;
    const Double whole = lanes::floor(place * static_cast<double>(count_));
    const Double inside = lanes::pick(lanes::below(whole, most), whole, Double(most));
    Double bin = lanes::pick(lanes::above(whole, 0.0), inside, Double(0.0));
    while (true) {
      const lanes::Wides down = both(lanes::above(bin, 0.0), lanes::below(words, up_to(bin - 1.0)));
      if (!any(down)) break;
      bin = lanes::pick(down, bin - 1.0, bin);
    }
    while (true) {
      const lanes::Wides up = both(lanes::below(bin, most), lanes::from(words, up_to(bin)));
      if (!any(up)) break;
      bin = lanes::pick(up, bin + 1.0, bin);
    }
    return lanes::as<std::int32_t>(bin);
  }

 private:
  /// How many words give at most this bin; not the last one.
  HYPGEN_FN Double up_to(Double bin) const {
    const Double end = low_ + width_ * ((bin + 1.0) / static_cast<double>(count_));
    const Double scaled = lanes::floor(law_.below(end) * 4294967296.0 + 0.5);
    const Double inside = lanes::pick(lanes::below(scaled, 4294967296.0), scaled, Double(4294967296.0));
    return lanes::pick(lanes::above(scaled, 0.0), inside, Double(0.0));
  }

  Law law_;
  Double low_;
  Double width_;
  std::int32_t count_;
};

}  // namespace hypgen::dist

namespace hypgen::posteriors {

template <int N, class Real>
HYPGEN_FN lanes::Lanes<Real> probability(const lanes::Lanes<Real>* stored, std::int32_t value) {
  if constexpr (N == 2) return value != 0 ? stored[0] : lanes::Lanes<Real>(Real{1}) - stored[0];
  return stored[value];
}
template <int N, class Real>
HYPGEN_FN lanes::Lanes<Real> probability(const lanes::Lanes<Real>* stored, lanes::Int value) {
  if constexpr (N == 2) return select(value != 0, stored[0], lanes::Lanes<Real>(Real{1}) - stored[0]);
  lanes::Lanes<Real> found = stored[0];
  for (int i = 1; i < N; ++i) lanes::assign(value == lanes::Int(i), found, stored[i]);
  return found;
}

template <int N, class Real>
HYPGEN_FN lanes::Mask normalise(lanes::Mask on, const lanes::Lanes<Real>* sums, lanes::Lanes<Real>* stored) {
  lanes::Lanes<Real> total(Real{});
  for (int i = 0; i < N; ++i) total = total + sums[i];
  const lanes::Mask possible = both(on, total > lanes::Lanes<Real>(Real{}));
  if constexpr (N == 2) {
    lanes::assign(possible, stored[0], sums[1] / total);
  } else {
    for (int i = 0; i < N; ++i) lanes::assign(possible, stored[i], sums[i] / total);
  }
  return possible;
}

}  // namespace hypgen::posteriors
