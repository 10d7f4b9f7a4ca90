// SPDX-License-Identifier: Apache-2.0
// What it takes to run a particle's past again with other random words.
//
// A particle's path is a function of its random words, and the words are functions of names. So a filter need
// not keep paths: it knows whose names a particle drew with in each step, and runs the model again. Moves of
// the Metropolis kind over a particle's first words then leave the posterior as it is.
#pragma once

#include <algorithm>
#include <array>
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

// The names of a unit's first words that moves change: those that some of its starts draw.
class MovedNames {
 public:
  static constexpr int kMost = 16;  // others keep what they draw

  void clear() { count_ = 0; }
  int size() const { return count_; }

  void add(std::uint32_t site, std::uint32_t index) {
    if (count_ == kMost || find(site, index) >= 0) return;
    names_[static_cast<std::size_t>(count_++)] = {site, index};
  }

  int find(std::uint32_t site, std::uint32_t index) const {
    for (int i = 0; i < count_; ++i) {
      const Name& name = names_[static_cast<std::size_t>(i)];
      if (name.site == site && name.index == index) return i;
    }
    return -1;
  }

  // The words of a start that draws with its own names.
  void draw(PhiloxDraws draws, std::uint32_t* words) const {
    for (int i = 0; i < count_; ++i) {
      const Name& name = names_[static_cast<std::size_t>(i)];
      words[i] = draws.word(name.site, name.index);
    }
  }

 private:
  struct Name {
    std::uint32_t site, index;
  };
  std::array<Name, kMost> names_;
  int count_ = 0;
};

// Draws, and notes what is drawn.
class NotedDraws {
 public:
  NotedDraws(const PhiloxDraws& draws, MovedNames& names) : draws_(draws), names_(names) {}

  std::uint32_t word(std::uint32_t site, std::uint32_t index) {
    names_.add(site, index);
    return draws_.word(site, index);
  }

 private:
  PhiloxDraws draws_;
  MovedNames& names_;
};

// The draws of a start: the words given, and for other names those of the particle that it descends from.
class MovedDraws {
 public:
  MovedDraws(const PhiloxDraws& origin, const MovedNames& names, const std::uint32_t* words)
      : origin_(origin), names_(names), words_(words) {}

  std::uint32_t word(std::uint32_t site, std::uint32_t index) {
    const int moved = names_.find(site, index);
    return moved < 0 ? origin_.word(site, index) : words_[moved];
  }

 private:
  PhiloxDraws origin_;
  const MovedNames& names_;
  const std::uint32_t* words_;
};

// Proposes other first words. Every change is as likely as its reverse: a word turns by a step or is drawn
// afresh, modulo 2^32. Steps of all sizes are proposed, so none has to be tuned.
class WordMove {
 public:
  static constexpr std::uint32_t kWords = 4 + MovedNames::kMost;  // that a move draws
  static constexpr std::uint32_t kSizes = 11;  // of steps: up to 1/2, 1/4, ... of all words

  // `first` is the index of the move's own words.
  WordMove(PhiloxDraws& draws, std::uint32_t site, std::uint32_t first)
      : draws_(draws), site_(site), first_(first) {}

  // The share of the old likelihood that the new one has to exceed.
  double threshold() { return (static_cast<double>(own(0)) + 0.5) * 0x1p-32; }

  void propose(int count, const std::uint32_t* now, std::uint32_t* next) {
    const std::uint32_t kind = own(1) >> 28;  // of 16: 1 all afresh, 3 one afresh, 12 steps
    const std::uint32_t size = below(own(2), kSizes), chosen = own(3);
    const int one = static_cast<int>(below(own(2), static_cast<std::uint32_t>(count)));
    for (int i = 0; i < count; ++i) {
      const std::uint32_t word = own(4 + static_cast<std::uint32_t>(i));
      if (kind == 0) {
        next[i] = word;
      } else if (kind < 4) {
        next[i] = i == one ? word : now[i];
      } else {
        const bool stays = (chosen >> (2 * i) & 3) == 0;
        const std::uint32_t step = stays ? 0 : word >> 1 >> size;
        next[i] = (word & 1) != 0 ? now[i] + step : now[i] - step;
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

}  // namespace hypgen
