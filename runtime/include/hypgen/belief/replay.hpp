// SPDX-License-Identifier: Apache-2.0
// What it takes to run a particle's past again with other random words.
//
// A particle's path is a function of its random words, and the words are functions of names. So a filter need
// not keep paths: it knows whose names a particle drew with in each step, and runs the model again. Moves of
// the Metropolis kind over a particle's first words then leave the posterior as it is.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "hypgen/random/philox.hpp"

namespace hypgen {

// How likely a path makes all that was seen: a product of many factors of at most 1.
class PathLikelihood {
 public:
  void multiply(double factor) {
    int shift = 0;
    fraction_ = std::frexp(fraction_ * factor, &shift);
    exponent_ += shift;
  }

  // Whether this is more than `share` of another one.
  bool exceeds(double share, const PathLikelihood& other) const {
    const std::int64_t more = std::clamp<std::int64_t>(exponent_ - other.exponent_, -1000, 1000);
    return std::ldexp(fraction_, static_cast<int>(more)) > share * other.fraction_;
  }

 private:
  double fraction_ = 1.0;
  std::int64_t exponent_ = 0;
};

// The names of a unit's first words that its particles keep: those that some of its starts draw. Moves change
// the first `moved()` of them.
class FirstNames {
 public:
  struct Name {
    std::uint32_t site, index;
    bool is(std::uint32_t a_site, std::uint32_t an_index) const {
      return site == a_site && index == an_index;
    }
  };

  // Forgets all names, and takes up to `most` new ones.
  void clear(int most) {
    most_ = static_cast<std::size_t>(most);
    moved_ = 0;
    names_.clear();
    std::size_t slots = 16;
    while (slots < 2 * most_) slots *= 2;
    slots_.assign(slots, -1);
  }

  int size() const { return static_cast<int>(names_.size()); }
  int moved() const { return moved_; }
  const Name* begin() const { return names_.data(); }
  const Name* end() const { return begin() + names_.size(); }

  void add(std::uint32_t site, std::uint32_t index) {
    int& slot = slots_[slot_of(site, index)];
    if (slot >= 0 || names_.size() == most_) return;
    slot = size();
    names_.push_back({site, index});
    moved_ = size();
  }

  // Lets moves change those names alone for which `is_moved(site, index)` holds.
  template <class IsMoved>
  void restrict_moves(const IsMoved& is_moved) {
    const auto end = std::stable_partition(names_.begin(), names_.end(),
                                           [&](const Name& name) { return is_moved(name.site, name.index); });
    moved_ = static_cast<int>(end - names_.begin());
    std::fill(slots_.begin(), slots_.end(), -1);
    for (int i = 0; i < size(); ++i) slots_[slot_of(begin()[i].site, begin()[i].index)] = i;
  }

  // The number of a name; -1 if it is none of these.
  int find(std::uint32_t site, std::uint32_t index) const { return slots_[slot_of(site, index)]; }

  // The words of a start that draws with its own names.
  void draw(PhiloxDraws draws, std::uint32_t* words) const {
    for (const Name& name : names_) *words++ = draws.word(name.site, name.index);
  }

 private:
  // Where a name stands in the table, or would.
  std::size_t slot_of(std::uint32_t site, std::uint32_t index) const {
    const std::size_t last = slots_.size() - 1;
    std::size_t slot = (site ^ (index * 0x9E3779B1U) >> 7) & last;
    for (; slots_[slot] >= 0; slot = (slot + 1) & last) {
      if (begin()[slots_[slot]].is(site, index)) break;
    }
    return slot;
  }

  std::size_t most_ = 0;
  int moved_ = 0;
  std::vector<Name> names_;
  std::vector<int> slots_ = {-1};  // a hash table of numbers of names; -1: free
};

// Draws, and notes those names for which `is_noted(site, index)` holds.
template <class IsNoted>
class NotedDraws {
 public:
  NotedDraws(const PhiloxDraws& draws, const IsNoted& is_noted, FirstNames& names)
      : draws_(draws), is_noted_(is_noted), names_(names) {}

  std::uint32_t word(std::uint32_t site, std::uint32_t index) {
    if (is_noted_(site, index)) names_.add(site, index);
    return draws_.word(site, index);
  }

 private:
  PhiloxDraws draws_;
  const IsNoted& is_noted_;
  FirstNames& names_;
};

// The draws of a start: the words given, and for other names those of the particle that it descends from. Most
// starts draw in the order of the names, so the name after the latest one is looked at first.
class OwnDraws {
 public:
  OwnDraws(const PhiloxDraws& origin, const FirstNames& names, const std::uint32_t* words)
      : origin_(origin), names_(names), words_(words), next_(names.begin()), end_(names.end()) {}

  std::uint32_t word(std::uint32_t site, std::uint32_t index) {
    if (next_ == end_ || !next_->is(site, index)) {
      const int own = names_.find(site, index);
      if (own < 0) return origin_.word(site, index);
      next_ = names_.begin() + own;
    }
    return words_[next_++ - names_.begin()];
  }

 private:
  PhiloxDraws origin_;
  const FirstNames& names_;
  const std::uint32_t* words_;
  const FirstNames::Name *next_, *end_;
};

// Proposes other first words. Every change is as likely as its reverse: a word turns by a step or is drawn
// afresh, modulo 2^32. Steps of all sizes are proposed, so none has to be tuned.
class WordMove {
 public:
  static constexpr std::uint32_t kAtOnce = 16;          // words that a move may change by steps
  static constexpr std::uint32_t kWidest = 128;         // words that it may draw afresh
  static constexpr std::uint32_t kWords = 4 + kWidest;  // that a move draws
  static constexpr std::uint32_t kSizes = 11;           // of steps: up to 1/2, 1/4, ... of all words

  // `first` is the index of the move's own words.
  WordMove(PhiloxDraws& draws, std::uint32_t site, std::uint32_t first)
      : draws_(draws), site_(site), first_(first) {}

  // The share of the old likelihood that the new one has to exceed.
  double threshold() { return (static_cast<double>(own(0)) + 0.5) * 0x1p-32; }

  // Proposes `next` in the place of `now`. Of more than kAtOnce words a random range changes. So many words are
  // mostly entries of arrays, each of few values, and a step hardly changes those: half of the moves draw a range
  // afresh: all words that may be drawn, a half, a quarter or an eighth of them.
  void propose(const FirstNames& names, const std::uint32_t* now, std::uint32_t* next) {
    std::copy_n(now, names.size(), next);
    const auto count = static_cast<std::uint32_t>(names.moved());
    const bool is_range = count > kAtOnce;
    const std::uint32_t kind = own(1) >> 28;
    const std::uint32_t afresh = is_range ? 8 : 1,
                        one_afresh = is_range ? 9 : 4;  // of 16; the rest are steps
    std::uint32_t wide = std::min(count, kAtOnce);
    if (is_range && kind < afresh) wide = std::min(count, kWidest) >> (kind % 4);
    const std::uint32_t first = is_range ? below(own(1) << 4, count) : 0;
    const std::uint32_t size = below(own(2), kSizes), chosen = own(3), one = below(own(2), wide);
    for (std::uint32_t i = 0; i < wide; ++i) {
      const std::uint32_t word = own(4 + i), place = (first + i) % count;
      if (kind < afresh) {
        next[place] = word;
      } else if (kind < one_afresh) {
        if (i == one) next[place] = word;
      } else {
        const bool stays = (chosen >> (2 * i) & 3) == 0;
        const std::uint32_t step = stays ? 0 : word >> 1 >> size;
        next[place] += (word & 1) != 0 ? step : 0 - step;
      }
    }
  }

 private:
  static std::uint32_t below(std::uint32_t word, std::uint32_t count) {
    return static_cast<std::uint32_t>((std::uint64_t{word} * count) >> 32);
  }
  std::uint32_t own(std::uint32_t i) { return draws_.word(site_, first_ + i); }

  PhiloxDraws& draws_;
  std::uint32_t site_, first_;
};

// Whose names the particles of a unit drew with in a step.
struct Descent {
  std::vector<std::uint32_t> parents;  // the slot that each particle was copied from; empty: its own
  std::uint32_t round = 0;             // how often the unit's draws were tried again
  bool weighed = true;                 // false: what was seen has not weighed, as no particle explained it
};

// The same of all steps so far. Memory of episodes before is used again.
class PastDescents {
 public:
  void clear() { size_ = 0; }

  void add(std::uint32_t round, bool weighed) {
    if (size_ == steps_.size()) steps_.emplace_back();
    Descent& step = steps_[size_++];
    step.parents.clear();
    step.round = round;
    step.weighed = weighed;
  }

  std::size_t size() const { return size_; }
  const Descent& operator[](std::size_t step) const { return steps_[step]; }
  Descent& back() { return steps_[size_ - 1]; }

 private:
  std::vector<Descent> steps_;  // `size_` in use
  std::size_t size_ = 0;
};

}  // namespace hypgen
