// SPDX-License-Identifier: Apache-2.0
// A whole state as the only unit of a particle filter, for models whose hidden variables are not independent.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "hypgen/belief/belief.hpp"
#include "hypgen/belief/redraw.hpp"
#include "hypgen/belief/replay.hpp"
#include "hypgen/belief/value_counts.hpp"
#include "hypgen/belief/value_moves.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen {

// What the particle filter calls (particle_filter.hpp). The numbers that are counted are the exported values,
// each by itself, and a hash of all fixed state: noise in one variable hides what another has lost.
template <class M>
struct WholeState {
  using Redrawn = Tracked<M>;
  using T = typename Redrawn::Model;  // as M, but for the type of the words of Fixed
  using Params = typename T::Params;
  using State = typename T::State;
  using Key = typename M::Key;
  struct Fixed : Redrawn::Own {
    typename T::Fixed values;
  };
  struct Evidence {
    Key key;
    State next;  // nothing until `accept`: `filter` writes what is visible too
  };
  static constexpr int kUnits = 1;
  static constexpr int kValues = M::kVariableCount + 1;
  static constexpr int kFirstWords = 64 + Redrawn::kWords;
  static constexpr bool kCountsApart = true;
  static constexpr bool kSeesFirst = SeesFirst<M>::value;
  static constexpr bool kRedraws = Redrawn::kAny;
  static constexpr bool kMovesValues = MovesValues<M>::value;

  static void see(const Params&, const Fixed&, const State&, int, const Key& key, Evidence& seen) {
    seen.key = key;
  }
  static const State& visible(const Evidence& seen) { return seen.next; }
  static double weigh_start(const Params& params, int, const Fixed& fixed, const State& state) {
    if constexpr (kSeesFirst) return T::init_likelihood(params, fixed.values, state);
    return 1.0;
  }

  // Draws hidden values, and forgets the reads that drawing them took.
  template <class D>
  static void draw(const Params& params, D& draws, int, Fixed& fixed, State& state) {
    T::init_hidden(params, draws, fixed.values, state);
    if constexpr (kRedraws) {
      for (TrackedWord& word : fixed.values.words) word.read = 0;
      fixed.start = state;
    }
  }
  template <class D>
  static double move(const Params& params, const Fixed& fixed, const State& state, int action,
                     const Evidence& seen, D& draws, int, State& next) {
    return T::filter(params, fixed.values, state, action, seen.key, draws, next);
  }
  static void copy(int, const Fixed& fixed, const State& state, Fixed& to_fixed, State& to_state) {
    to_fixed = fixed;
    to_state = state;
  }

  static int values(int, const Fixed& fixed, const State& state, double* out) {
    std::int32_t exported[M::kVariableCount + 1];
    export_state(fixed, state, exported);
    std::copy_n(exported, M::kVariableCount, out);
    if constexpr (kRedraws) {  // what copies draw again tells them apart
      return M::kVariableCount;
    } else {
      std::uint64_t hash = 0;
      for (std::size_t i = 0; i < kWords; ++i) {
        std::uint32_t word;
        std::memcpy(&word, reinterpret_cast<const char*>(&fixed.values) + i * sizeof word, sizeof word);
        hash = ValueSet::mixed(hash ^ word);
      }
      out[M::kVariableCount] = static_cast<double>(hash >> 12);
      return kValues;
    }
  }

  static void export_state(const Fixed& fixed, const State& state, std::int32_t* out) {
    const typename T::Fixed unread = fixed.values;  // a copy, so that the particle notes no read
    T::export_state(unread, state, out);
  }

  // Fixed state as the model has it.
  static typename M::Fixed plain(const Fixed& fixed) {
    if constexpr (kRedraws) {
      typename M::Fixed words;
      for (std::size_t i = 0; i < kWords; ++i) words.words[i] = fixed.values.words[i].value;
      return words;
    } else {
      return fixed.values;
    }
  }

  // Fixed state of which all has been read.
  static Fixed all_read(const typename M::Fixed& fixed) {
    Fixed read{};
    if constexpr (kRedraws) {
      for (std::size_t i = 0; i < kWords; ++i) read.values.words[i] = {fixed.words[i], ~std::uint32_t{0}};
    } else {
      read.values = fixed;
    }
    return read;
  }

  // Moves of values (value_moves.hpp).
  using Move = ValueMove<M>;
  static double start_density(const Params& params, const Fixed& fixed, const State& start) {
    return T::init_density(params, fixed.values, start);
  }
  static double weigh(const Params& params, const Fixed& fixed, const State& state, int action,
                      const Evidence& seen) {
    return T::weigh_hidden(params, fixed.values, state, action, seen.key, seen.next);
  }

  // Redraw (redraw.hpp). Its first proposal draws all unread words, the second those of arrays alone: that is
  // more likely to leave the read values as they are.
  static constexpr int kProposals = 2;

  static bool is_redrawn(std::uint32_t site, std::uint32_t index) { return Redrawn::word(site, index) >= 0; }

  // Entries of arrays are left to the redraw.
  static bool is_moved(std::uint32_t site, std::uint32_t index) {
    return Redrawn::word(site, index) < Redrawn::kSingles;
  }

  static bool propose(int proposal, const FirstNames& names, const Fixed& fixed, const PhiloxDraws& fresh,
                      std::uint32_t* words) {
    constexpr std::uint32_t kSites[] = {site_id("belief:all"), site_id("belief:entries")};
    if (proposal == 0 && Redrawn::kSingles == 0) return false;  // the second one is the same
    const int first = proposal == 0 ? 0 : Redrawn::kSingles;
    PhiloxDraws draws = fresh;
    bool any = false;
    for (const FirstNames::Name& name : names) {
      std::uint32_t& own = *words++;
      const int word = Redrawn::word(name.site, name.index);
      if (word < first || T::is_word_read(fixed.values, word)) continue;
      own = draws.word(kSites[proposal], static_cast<std::uint32_t>(word));
      any = true;
    }
    return any;
  }

  static bool replace(Fixed& fixed, const Fixed& other) {
    if (std::memcmp(&other.start, &fixed.start, sizeof fixed.start) != 0) return false;
    for (std::size_t i = 0; i < kWords; ++i) {
      const TrackedWord &now = fixed.values.words[i], &next = other.values.words[i];
      if (((next.value ^ now.value) & now.read) != 0) return false;
    }
    for (std::size_t i = 0; i < kWords; ++i) fixed.values.words[i].value = other.values.words[i].value;
    return true;
  }

 private:
  static constexpr std::size_t kWords = sizeof(typename M::Fixed) / sizeof(std::uint32_t);
};

}  // namespace hypgen
