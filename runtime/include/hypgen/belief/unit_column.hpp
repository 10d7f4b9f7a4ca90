// SPDX-License-Identifier: Apache-2.0
// What a particle filter keeps of one unit besides its values in the particles.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hypgen/belief/replay.hpp"
#include "hypgen/belief/systematic.hpp"
#include "hypgen/belief/value_counts.hpp"

namespace hypgen {

// Arrays have an entry for each particle, of which `count` are in use.
template <int kValues>
struct UnitColumn {
  // Values that are counted together.
  struct Part {
    int first, count;            // of the numbers that are a unit's values
    std::size_t most;            // distinct ones that particles have which have all parted
    std::size_t first_distinct;  // that the first particles had
    std::size_t distinct;        // that particles have
  };

  void allocate(std::size_t most, std::size_t chunks) {
    weights.resize(most);
    next_weights.resize(most);
    likelihoods.resize(most);
    next_likelihoods.resize(most);
    origins.resize(most);
    next_origins.resize(most);
    picks.reserve(most);
    sums.resize(chunks);
    found.clear(most);
  }

  std::uint32_t* words_of(std::uint32_t i) {
    return words.data() + i * static_cast<std::size_t>(names.size());
  }

  double sum(std::size_t chunks) const {
    double all = 0.0;
    for (std::size_t i = 0; i < chunks; ++i) all += sums[i];
    return all;
  }

  double effective_size() const {
    double squares = 0.0;
    for (std::uint32_t i = 0; i < count; ++i) squares += weights[i] * weights[i];
    return 1.0 / squares;
  }

  // Notes how probable what was seen was. The mean forgets: what is known narrows from step to step.
  void note_surprise() {
    const double bits = -std::log2(std::max(total, 1e-300));
    surprise = noted > 1 ? bits - expected : 0.0;
    expected = noted > 1 ? 0.8 * expected + 0.2 * bits : bits;
    ++noted;
  }

  // Makes the weights and likelihoods after a step those of the unit.
  void take_weights() {
    for (std::uint32_t i = 0; i < count; ++i) weights[i] = next_weights[i] / total;
    likelihoods.swap(next_likelihoods);
  }

  // Chooses particles to copy by systematic sampling.
  void pick(std::uint32_t word, std::uint32_t wanted) {
    picks.resize(wanted);
    choose([this](int i) { return weights[static_cast<std::size_t>(i)]; }, static_cast<int>(count), word,
           wanted, [this](std::size_t i, int from) { picks[i] = static_cast<std::uint32_t>(from); });
  }

  // Copies all but values from the particles chosen.
  void copy_picks() {
    count = static_cast<std::uint32_t>(picks.size());
    const auto each = static_cast<std::size_t>(names.size());
    for (std::uint32_t i = 0; i < count; ++i) {
      next_likelihoods[i] = likelihoods[picks[i]];
      next_origins[i] = origins[picks[i]];
      std::copy_n(words_of(picks[i]), each, next_words.data() + i * each);
    }
    likelihoods.swap(next_likelihoods);
    origins.swap(next_origins);
    words.swap(next_words);
    std::fill_n(weights.begin(), count, 1.0 / static_cast<double>(count));
  }

  // Whether moves can change anything. The past is kept for them alone.
  bool can_move() const { return moved > 0 && !parts.empty(); }

  // How many values the part has left that has lost most.
  std::size_t distinct() const {
    std::size_t least = count;
    for (const Part& part : parts) least = std::min(least, part.distinct);
    return least;
  }

  // Whether copies have not all parted.
  bool repeats() const {
    for (const Part& part : parts) {
      if (static_cast<double>(part.distinct) <
          0.95 * static_cast<double>(std::min<std::size_t>(part.most, count)))
        return true;
    }
    return false;
  }

  // The share of its values that the part has lost that has lost most.
  double lost() const {
    double most = 0.0;
    for (const Part& part : parts)
      most = std::max(most, 1.0 - static_cast<double>(part.distinct) /
                                      static_cast<double>(std::min<std::size_t>(part.most, count)));
    return most;
  }

  // Whether few values are left of a part that had many.
  bool is_depleted(std::size_t few, std::size_t most) const {
    for (const Part& part : parts) {
      if (2 * part.first_distinct > most && part.distinct < few && part.distinct < count) return true;
    }
    return false;
  }

  std::uint32_t count = 0;     // particles
  bool start_weighed = false;  // what is visible at the start has weighed
  std::uint32_t born = 0;      // the step at which the unit has started, or started again
  bool starts_again = false;   // in the latest step
  int moved = 0;               // words or values that moves may change
  FirstNames names;
  std::vector<std::uint32_t> words, next_words;      // names.size() for each particle
  std::vector<std::uint32_t> origins, next_origins;  // the scenarios with whose other names particles started
  std::vector<double> weights, next_weights;
  std::vector<PathLikelihood> likelihoods, next_likelihoods;
  PastDescents past;                 // by step
  std::vector<std::uint32_t> picks;  // of the latest resampling
  std::vector<double> sums;          // of the latest weights, by chunk
  double total = 0.0;                // of these
  std::uint32_t round = 0;           // whose draws they come from
  bool explained = true;
  bool resampled = false;  // in the latest step
  ValueScale<kValues> scale;
  std::vector<Part> parts;
  ValueSet found;           // scratch: of one part's values
  double surprise = 0.0;    // bits by which the latest total is below what was expected
  double expected = 0.0;    // bits: a mean over the steps before
  int noted = 0;            // steps since the start
  std::uint32_t moves = 0;  // of all particles in the latest step
};

}  // namespace hypgen
