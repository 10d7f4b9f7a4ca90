// SPDX-License-Identifier: Apache-2.0
// How the units of a particle filter start, what of their starts is drawn again, and which of their values are
// counted.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/belief/first_draws.hpp"
#include "hypgen/belief/replay.hpp"
#include "hypgen/belief/unit_column.hpp"
#include "hypgen/belief/value_counts.hpp"

namespace hypgen {

// U says what a unit is:
//   types Params, Fixed, State, Key, Evidence
//   int kUnits;                                  // how many there are
//   int kValues;                                 // numbers that `values` writes, at most
//   int kFirstWords;                             // words of a start that each particle keeps, at most
//   bool kCountsApart;                           // each value is counted by itself, and not all together
//   bool kSeesFirst;                             // what is visible at the start tells of units
//   bool kRedraws;                               // copies draw again what they have not read (redraw.hpp)
//   bool kMovesValues;                           // moves change values, not words (value_moves.hpp)
//   double weigh_start(P, int unit, F, S);       // how likely a unit's initial values make that
//   void see(P, F, S, int action, Key, Evidence&);             // what all particles of a step share
//   const State& visible(const Evidence&);                     // the visible variables after the step
//   void draw(P, D&, int unit, Fixed&, State&);                // a unit's initial values
//   double move(P, F, S, int action, const Evidence&, D&, int unit, State& next);  // and how likely it makes
//                                                                                  // what was seen
//   void copy(int unit, F, S, Fixed&, State&);
//   int values(int unit, F, S, double* out);                   // a unit's values, and how many
// and if kMovesValues, of a single unit:
//   type Move                                                  // proposes other values of Fixed
//   double start_density(P, F, S start);                       // how probable its values are at the start
//   double weigh(P, F, S, int action, const Evidence&);        // what `move` gives; visible variables are known
// and if kRedraws:
//   bool is_redrawn(std::uint32_t site, std::uint32_t index);  // the word of that name may be drawn again
//   bool is_moved(std::uint32_t site, std::uint32_t index);    // moves may change the word of that name
//   int kProposals;                                            // `propose` can make
//   bool propose(int proposal, const FirstNames&, F, const PhiloxDraws& fresh, std::uint32_t* words);
//       // draws first words again whose values have not been read; false: all of them have
//   bool replace(Fixed&, F other);  // takes values that other first words give, if all that was read stays
template <class U>
class UnitStarts {
 protected:
  using Params = typename U::Params;
  using Fixed = typename U::Fixed;
  using State = typename U::State;
  using Column = UnitColumn<U::kValues>;

  struct Particle {
    Fixed fixed;
    State state;
  };

  // `most`: the particles of a unit at the start.
  UnitStarts(const Params& params, std::uint32_t most)
      : params_(params), most_(most), starts_(U::kUnits), columns_(U::kUnits) {}

  void begin(int unit) {
    Column& column = columns_[unit];
    column.count = most_;
    if constexpr (U::kMovesValues) {
      column.names.clear(0);
      column.moved = 1;
    } else {
      note_names(unit);
      column.moved = column.names.moved();
    }
    column.words.resize(static_cast<std::size_t>(most_) * static_cast<std::size_t>(column.names.size()));
    column.next_words.resize(column.words.size());
    column.past.clear();
    column.moves = 0;
    column.noted = 0;
    column.surprise = 0.0;
    column.explained = true;
    column.born = 0;
    column.starts_again = false;
    column.start_weighed = false;
    starts_[unit] = start_;
    std::iota(column.origins.begin(), column.origins.end(), 0U);
    if constexpr (U::kSeesFirst) {
      choose_starts(unit);
    } else {
      std::fill(column.weights.begin(), column.weights.end(), 1.0 / static_cast<double>(most_));
    }
  }

  // Finds the names of the words that particles keep. What is drawn again has its place before the rest.
  void note_names(int unit) {
    FirstNames& names = columns_[unit].names;
    names.clear(U::kFirstWords);
    if constexpr (U::kRedraws) note_names(unit, &U::is_redrawn);
    note_names(unit, [](std::uint32_t, std::uint32_t) { return true; });
    if constexpr (U::kRedraws) names.restrict_moves(&U::is_moved);
  }

  template <class IsNoted>
  void note_names(int unit, const IsNoted& is_noted) {
    for (std::uint32_t i = 0; i < kNotedStarts; ++i) {
      NotedDraws noted(PhiloxDraws(key_, i, 0), is_noted, columns_[unit].names);
      Particle particle{fixed_, start_};
      U::draw(params_, noted, unit, particle.fixed, particle.state);
    }
  }

  // Draws a unit's starts given what is visible then.
  void choose_starts(int unit) {
    Column& column = columns_[unit];
    FirstDraws first(most_, 1);
    do {
      for (std::uint32_t i = 0; i < most_; ++i) {
        PhiloxDraws draws(key_, first.count(), 0);
        Particle candidate{fixed_, start_};
        U::draw(params_, draws, unit, candidate.fixed, candidate.state);
        const double likelihood = U::weigh_start(params_, unit, candidate.fixed, candidate.state);
        first.add(&likelihood);
      }
    } while (first.wants_more());
    const std::uint32_t word = PhiloxDraws(key_, static_cast<std::uint32_t>(unit), 0).word(kResampleSite, 0);
    column.explained = first.choose(0, word, [&](std::uint32_t i, std::uint32_t candidate, double weight) {
      column.origins[i] = candidate;
      column.weights[i] = weight;
    });
    column.start_weighed = column.explained;
  }

  // Draws a unit's initial values with these words and, for other names, with those of particle `origin`.
  void draw(int unit, std::uint32_t origin, const std::uint32_t* words, Particle& particle) const {
    const Column& column = columns_[unit];
    OwnDraws draws(PhiloxDraws(key_, origin, column.born), column.names, words);
    U::draw(params_, draws, unit, particle.fixed, particle.state);
  }

  // Takes the likelihoods of a unit's starts, and how they are spread.
  void measure(int unit, const std::vector<Particle>& now) {
    Column& column = columns_[unit];
    std::fill(column.likelihoods.begin(), column.likelihoods.end(), PathLikelihood{});
    column.scale.clear();
    double values[U::kValues + 1];
    int count = 0;
    for (std::uint32_t i = 0; i < most_; ++i) {
      const Particle& start = now[i];
      if (column.start_weighed)
        column.likelihoods[i].multiply(U::weigh_start(params_, unit, start.fixed, start.state));
      if (U::kCountsApart) continue;
      count = U::values(unit, start.fixed, start.state, values);
      column.scale.include(values, count);
    }
    column.parts.clear();
    if constexpr (U::kCountsApart) {
      find_parts(unit, now);
    } else {
      column.parts.push_back({0, count, most_, 0, 0});
    }
    count_values(unit, now);
    for (typename Column::Part& part : column.parts) {
      part.first_distinct = part.distinct;
      if (U::kCountsApart) part.most = part.distinct;
    }
    if (column.parts.empty() && !U::kRedraws) column.names.clear(0);  // nothing will ever be drawn again
  }

  // Finds the values of which many particles have one of their own at the start, as far as some tell. Where values
  // move, all fixed state together is counted too, however few values it has.
  void find_parts(int unit, const std::vector<Particle>& now) {
    const std::uint32_t asked = std::min(most_, kAskedStarts);
    std::vector<double> values(asked * static_cast<std::size_t>(U::kValues + 1));
    int count = 0;
    for (std::uint32_t i = 0; i < asked; ++i)
      count = U::values(unit, now[i].fixed, now[i].state, values.data() + i * (U::kValues + 1));
    for (int value = 0; value < count && columns_[unit].parts.size() < kMostParts; ++value) {
      ValueSet found(asked);
      for (std::uint32_t i = 0; i < asked; ++i)
        found.add(ValueSet::hash(values.data() + i * (U::kValues + 1) + value, 1));
      const bool is_all = U::kMovesValues && value + 1 == count;
      if (is_all || 2 * found.size() > asked) columns_[unit].parts.push_back({value, 1, 0, 0, 0});
    }
  }

  void count_values(int unit, const std::vector<Particle>& particles) {
    Column& column = columns_[unit];
    double values[U::kValues + 1];
    for (typename Column::Part& part : column.parts) {
      column.found.clear(column.count);
      for (std::uint32_t i = 0; i < column.count; ++i) {
        if (!(column.weights[i] > 0.0)) continue;
        U::values(unit, particles[i].fixed, particles[i].state, values);
        column.found.add(ValueSet::hash(values + part.first, part.count));
      }
      part.distinct = column.found.size();
    }
  }

  // Draws again what a copy has not read.
  void redraw([[maybe_unused]] int unit, [[maybe_unused]] std::uint32_t i,
              [[maybe_unused]] Particle& particle, [[maybe_unused]] const PhiloxDraws& fresh) {
    if constexpr (U::kRedraws) {
      Column& column = columns_[unit];
      std::uint32_t words[U::kFirstWords];
      for (int proposal = 0; proposal < U::kProposals; ++proposal) {
        std::copy_n(column.words_of(i), column.names.size(), words);
        if (!U::propose(proposal, column.names, particle.fixed, fresh, words)) continue;
        Particle other{fixed_, starts_[unit]};
        draw(unit, column.origins[i], words, other);
        if (U::replace(particle.fixed, other.fixed))
          std::copy_n(words, column.names.size(), column.words_of(i));
      }
    }
  }

  const Params& params_;
  std::uint32_t most_;
  StreamKey key_{};
  Fixed fixed_{};  // with `start_`: the visible variables at the start; hidden ones are 0
  State start_{};
  std::vector<State> starts_;  // the visible variables when each unit has started
  std::vector<Column> columns_;

 private:
  static constexpr std::uint32_t kNotedStarts = 16;    // that say which words a start draws
  static constexpr std::uint32_t kAskedStarts = 1024;  // that say which values many starts have of their own
  static constexpr std::size_t kMostParts = 16;        // values that are counted apart
};

}  // namespace hypgen
