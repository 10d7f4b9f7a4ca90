// SPDX-License-Identifier: Apache-2.0
// A draw source that gives every outcome, one after the other, with its probability.
//
// What becomes of a random word is decided by comparing it. So a word may stand for an interval of words: a
// comparison that holds in a part of it splits it there, and the code runs once for either side. What runs is
// the text that also draws at random, and a probability is the share of words that lead there, clipped and
// rounded probabilities included. Words that nobody compares split nothing. An interval is one of 63 bits: a
// second word (fine_words.hpp) is the lower end of the first.
//
//   EnumeratingDraws draws;
//   do {
//     step(params, fixed, state, action, draws, next);
//     use(next, draws.probability());
//   } while (draws.next());
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hypgen/random/fine_words.hpp"
#include "hypgen/random/word_thresholds.hpp"

namespace hypgen::exact {

class EnumeratingDraws;

// Stands for an interval of words. Copies are the same word; `~` gives it counted from the other end.
class EnumeratedWord {
 public:
  friend bool operator<(EnumeratedWord word, std::uint64_t bound) {
    return word.is_below(bound << dist::kLowBits);
  }
  friend bool operator>=(EnumeratedWord word, std::uint64_t bound) { return !(word < bound); }
  friend EnumeratedWord operator~(EnumeratedWord word) {
    return {word.draws_, word.number_, !word.mirrored_};
  }

  // What distributions.hpp has for plain words.
  friend std::uint64_t piece_of(EnumeratedWord word, std::uint64_t first, std::uint64_t pieces) {
    const std::uint64_t words = dist::kWords - first;
    std::uint64_t low = 0;
    for (std::uint64_t high = pieces - 1; low < high;) {
      const std::uint64_t middle = low + (high - low) / 2;
      const std::uint64_t end = ((middle + 1) * words + pieces - 1) / pieces;  // of the pieces up to this one
      if (word < first + end) {
        high = middle;
      } else {
        low = middle + 1;
      }
    }
    return low;
  }
  friend std::uint32_t typical(EnumeratedWord word) { return word.middle(); }

  // What fine_words.hpp has for plain words.
  template <class Fine>
  friend bool is_below(EnumeratedWord word, std::uint64_t mass, const Fine& /*fine*/) {
    return word.is_below(mass);
  }
  template <class Fine>
  friend std::uint64_t piece_at(EnumeratedWord word, const dist::Pieces& pieces, const Fine& /*fine*/) {
    std::uint64_t low = 0;
    for (std::uint64_t high = pieces.count - 1; low < high;) {
      const std::uint64_t middle = low + (high - low) / 2;
      if (word.is_below(pieces.end(middle))) {
        high = middle;
      } else {
        low = middle + 1;
      }
    }
    return low;
  }

 private:
  friend class EnumeratingDraws;
  EnumeratedWord(EnumeratingDraws* draws, std::size_t number, bool mirrored)
      : draws_(draws), number_(number), mirrored_(mirrored) {}

  bool is_below(std::uint64_t bound) const;
  std::uint32_t middle() const;

  EnumeratingDraws* draws_;
  std::size_t number_;
  bool mirrored_;
};

// The draws of one step (or of initial values): on the first path when made or started, then, path by path,
// on all others. Code that is run again must compare the same words in the same order.
class EnumeratingDraws {
 public:
  // Goes to the first path.
  void start() {
    splits_.clear();
    rewind();
  }

  // Goes to the next path; false if there is none.
  bool next() {
    while (!splits_.empty() && splits_.back() == Side::kAbove) splits_.pop_back();
    if (splits_.empty()) return false;
    splits_.back() = Side::kAbove;
    rewind();
    return true;
  }

  // Of the path so far.
  double probability() const {
    double product = 1.0;
    for (const Drawn& drawn : drawn_) product *= dist::share_of(drawn.high - drawn.low);
    return product;
  }

  EnumeratedWord word(std::uint32_t site, std::uint32_t index) {
    std::size_t number = 0;
    while (number < drawn_.size() && !(drawn_[number].site == site && drawn_[number].index == index)) {
      ++number;
    }
    if (number == drawn_.size()) {
      Drawn& drawn = drawn_.emplace_back();
      drawn.site = site;
      drawn.index = index;
    }
    return {this, number, false};
  }

 private:
  friend class EnumeratedWord;
  enum class Side : std::uint8_t { kBelow, kAbove };
  // A word: any 63 bits of low .. high - 1.
  struct Drawn {
    std::uint32_t site = 0;
    std::uint32_t index = 0;
    std::uint64_t low = 0;
    std::uint64_t high = dist::kWhole;
  };

  void rewind() {
    drawn_.clear();
    passed_ = 0;
  }

  bool is_below(std::size_t number, std::uint64_t bound) {
    Drawn& drawn = drawn_[number];
    if (drawn.high <= bound) return true;
    if (drawn.low >= bound) return false;
    if (passed_ == splits_.size()) splits_.push_back(Side::kBelow);
    const bool below = splits_[passed_++] == Side::kBelow;
    (below ? drawn.high : drawn.low) = bound;
    return below;
  }

  std::vector<Drawn> drawn_;  // on this path
  std::vector<Side> splits_;  // of the path, in the order in which they are met
  std::size_t passed_ = 0;    // of them, by now
};

inline bool EnumeratedWord::is_below(std::uint64_t bound) const {
  if (!mirrored_) return draws_->is_below(number_, bound);
  return bound >= dist::kWhole || !draws_->is_below(number_, dist::kWhole - bound);
}

inline std::uint32_t EnumeratedWord::middle() const {
  const EnumeratingDraws::Drawn& drawn = draws_->drawn_[number_];
  const std::uint64_t bits = drawn.low + (drawn.high - drawn.low) / 2;
  const auto word = static_cast<std::uint32_t>(bits >> dist::kLowBits);
  return mirrored_ ? ~word : word;
}

}  // namespace hypgen::exact
