// SPDX-License-Identifier: Apache-2.0
// A particle filter of independent units that share an array of particles. Where no hidden variables are
// independent of the rest, the whole state is its only unit.
//
// Each unit owns a column of the array: its variables in every particle, and weights and a number of particles
// of its own. Particles are resampled where weights degenerate. Copies part again by moves of the Metropolis
// kind over their first words, which run the model again over all that was seen (replay.hpp). Such a move
// leaves the posterior as it is. docs/decisions/0035-a-particles-past-is-replayed.md has the reasons.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/belief/replay.hpp"
#include "hypgen/belief/unit_column.hpp"
#include "hypgen/belief/unit_starts.hpp"
#include "hypgen/belief/value_counts.hpp"
#include "hypgen/core/workers.hpp"

namespace hypgen {

// unit_starts.hpp says what U has. Jobs write to particles or to columns of their own, and sums are taken in the
// order of slots. So results are the same for every number of threads.
template <class U>
class ParticleFilter : UnitStarts<U> {
  using Starts = UnitStarts<U>;
  using Starts::begin, Starts::count_values, Starts::draw, Starts::measure, Starts::redraw;
  using Starts::columns_, Starts::fixed_, Starts::key_, Starts::most_, Starts::params_, Starts::start_,
      Starts::starts_;
  using typename Starts::Column;
  using typename Starts::Particle;

 public:
  using Params = typename U::Params;
  using Fixed = typename U::Fixed;
  using State = typename U::State;

  // `most`: the particles of a unit at the start, and where what it may be is as wide as then.
  ParticleFilter(const Params& params, std::size_t most)
      : Starts(params, static_cast<std::uint32_t>(most)), now_(most), next_(most) {
    for (Column& column : columns_) column.allocate(most, chunks(most_));
    past_.reserve(kLongestPast);
  }

  void use(Workers* workers) { workers_ = workers; }

  // Draws all particles at visible variables. False if no start of some unit explains these.
  bool init(StreamKey key, const Fixed& fixed, const State& state) {
    key_ = key;
    fixed_ = fixed;
    start_ = state;
    step_ = 0;
    resampled_ = false;
    lost_starts_ = false;
    past_.clear();
    for_units([&](int unit) { begin(unit); });
    for_slots(most_, [&](std::uint32_t i) {
      now_[i] = {fixed, state};
      for (int unit = 0; unit < U::kUnits; ++unit) {
        Column& column = columns_[unit];
        column.names.draw(PhiloxDraws(key_, column.origins[i], 0), column.words_of(i));
        draw(unit, column.origins[i], column.words_of(i), now_[i]);
        if constexpr (U::kSeesFirst && U::kRedraws) {
          U::weigh_start(params_, unit, now_[i].fixed, now_[i].state);  // reads what it tells of
          redraw(unit, i, now_[i], PhiloxDraws(key_, i, 0));            // several may have the same start
        }
      }
    });
    bool explained = true;
    for_units([&](int unit) { measure(unit, now_); });
    for (const Column& column : columns_) explained = explained && column.explained;
    return explained;
  }

  // Moves all particles and weighs them by what was seen, up to `rounds` times with other draws where none of
  // a unit explains that. Gives whether some particle of each unit does. The belief stays as it is,
  // but for values that nothing has read, which other draws take too.
  bool weigh(const State& visible, int action, const typename U::Key& key, std::uint32_t rounds) {
    latest_.action = action;
    U::see(params_, fixed_, visible, action, key, latest_.seen);
    for (Column& column : columns_) {
      column.explained = false;
      column.starts_again = false;
    }
    return weigh_rounds(0, rounds);
  }

  // Starts each unit again of which `weigh` has found no particle that explains what was seen: with particles
  // from the initial law, weighed by this step alone, if any of them explains it. Gives how many units do so.
  int restart(const State& visible) {
    for (std::size_t unit = 0; unit < U::kUnits; ++unit) {
      columns_[unit].starts_again = !columns_[unit].explained;
      if (columns_[unit].starts_again) starts_[unit] = visible;
    }
    weigh_rounds(kRestart, 2 * kRestart);
    int restarted = 0;
    for (Column& column : columns_) {
      column.starts_again = column.starts_again && column.explained;
      restarted += column.starts_again;
    }
    return restarted;
  }

  // Makes the moved particles the belief. A unit of which none explains what was seen keeps its weights.
  void accept() {
    const bool any_moves =
        std::any_of(columns_.begin(), columns_.end(), [](const Column& column) { return column.can_move(); });
    if (any_moves && past_.size() == step_ && step_ < kLongestPast) {
      if constexpr (U::kMovesValues) {
        latest_.before = now_[0].state;
        latest_.seen.next = next_[0].state;
      }
      past_.push_back(latest_);
    }
    const std::uint32_t before = largest();
    ++step_;
    for_units([&](int unit) { take_weights(unit); });
    now_.swap(next_);
    gather(before);
    for_slots(largest(), [&](std::uint32_t i) {
      if constexpr (U::kMovesValues) {
        move_values(i, PhiloxDraws(key_, i, step_), moves_of(columns_[0], i));
      } else {
        for (int unit = 0; unit < U::kUnits; ++unit) rejuvenate(unit, i);
      }
    });
    for_units([&](int unit) {
      if (columns_[unit].moves > 0 || columns_[unit].resampled) count_values(unit, now_);
    });
  }

  // Takes the weight of a unit's particles for which `is_gone(i)` holds, unless it holds for all.
  template <class IsGone>
  void drop(int unit, const IsGone& is_gone) {
    Column& column = columns_[unit];
    column.total = 0.0;
    for (std::uint32_t i = 0; i < column.count; ++i) {
      column.next_weights[i] = is_gone(i) ? 0.0 : column.weights[i];
      column.total += column.next_weights[i];
    }
    if (!(column.total > 0.0)) return;
    for (std::uint32_t i = 0; i < column.count; ++i)
      column.weights[i] = column.next_weights[i] / column.total;
  }

  // Makes these the particles of all units. Their past is not known, so they stay as they are.
  void import(const std::vector<Fixed>& fixed, const std::vector<State>& states,
              const std::vector<double>& weights) {
    for (std::uint32_t i = 0; i < most_; ++i) now_[i] = {fixed[i], states[i]};
    for (Column& column : columns_) {
      column.count = most_;
      column.names.clear(0);
      column.moved = 0;
      std::iota(column.origins.begin(), column.origins.end(), 0U);
      column.weights = weights;
    }
  }

  // Whether some unit has been resampled in this episode.
  bool has_resampled() const { return resampled_; }

  // Whether some unit's first starts were all given up for others in the first step.
  bool has_lost_starts() const { return lost_starts_; }

  const Fixed& fixed(int i) const { return now_[static_cast<std::size_t>(i)].fixed; }
  const State& state(int i) const { return now_[static_cast<std::size_t>(i)].state; }

  // The scenario with whose names a particle has drawn what it has not drawn again.
  std::uint32_t origin(int unit, int i) const { return columns_[unit].origins[static_cast<std::size_t>(i)]; }

  int count(int unit) const { return static_cast<int>(columns_[unit].count); }
  double weight(int unit, int i) const { return columns_[unit].weights[static_cast<std::size_t>(i)]; }

  std::vector<UnitHealth> health() const {
    std::vector<UnitHealth> found;
    for (const Column& column : columns_) {
      const bool is_depleted =
          !U::kMovesValues && column.is_depleted(kFewValues, most_);  // moves find others
      found.push_back(
          {column.count, column.effective_size(), column.distinct(), column.surprise, is_depleted});
    }
    return found;
  }

  // Writes the unit's variables in one of its particles.
  void put(int unit, int i, Fixed& fixed, State& state) const {
    const Particle& from = now_[static_cast<std::size_t>(i)];
    U::copy(unit, from.fixed, from.state, fixed, state);
  }

  double effective_size(int unit) const { return columns_[unit].effective_size(); }

 private:
  static constexpr std::uint32_t kMoveSite = site_id("belief:move");
  static constexpr std::uint32_t kChunk = 32;         // particles whose weights are added up at a time
  static constexpr std::uint32_t kJob = 8;            // particles of another job: few, as their work differs
  static constexpr std::uint32_t kLongestPast = 256;  // steps that a move can run again
  static constexpr std::uint32_t kRestart = 32;       // the first round of draws of a unit that starts again
  static constexpr std::uint32_t kReplays = 8;        // steps run again for each particle and step
  static constexpr std::uint32_t kValueMoves = 16;    // of a particle in a step, where most values are lost
  static constexpr std::size_t kFewValues = 20;       // of a unit that had many, they are doubtful
  static constexpr double kManyValues = 512.0;        // as spread as that, a unit takes all its particles

  struct Step {
    int action;
    typename U::Evidence seen;
    State before;  // for moves of values alone
  };

  static std::size_t chunks(std::uint32_t slots) { return (slots + kChunk - 1) / kChunk; }

  template <class Do>
  void for_units(const Do& each) {
    share(workers_, U::kUnits, [&](std::size_t unit) { each(static_cast<int>(unit)); });
  }

  template <class Do>
  void for_slots(std::uint32_t slots, const Do& each) {
    share(workers_, (slots + kJob - 1) / kJob, [&](std::size_t job) {
      const auto first = static_cast<std::uint32_t>(job) * kJob;
      for (std::uint32_t i = first; i < std::min(first + kJob, slots); ++i) each(i);
    });
  }

  std::uint32_t largest() const {
    std::uint32_t most = 0;
    for (const Column& column : columns_) most = std::max(most, column.count);
    return most;
  }

  // How few particles a unit may have. Where there are many units, each has fewer.
  std::uint32_t least() const { return std::max<std::uint32_t>(1, most_ / std::min(U::kUnits, 8)); }

  // A step --------------------------------------------------------------------------------------------------

  std::uint32_t scenario(std::uint32_t slot, std::uint32_t round) const { return slot + round * most_; }

  // Weighs the units that are not explained, with the draws of each round until all are. Gives whether they are.
  bool weigh_rounds(std::uint32_t round, std::uint32_t last) {
    const std::uint32_t slots = largest();
    bool explained = false;
    for (; round <= last && !explained; ++round) {
      share(workers_, chunks(slots), [&](std::size_t chunk) { weigh_chunk(chunk, slots, round); });
      explained = true;
      for (Column& column : columns_) {
        if (column.explained) continue;
        column.total = column.sum(chunks(column.count));
        column.round = round;
        column.explained = column.total > 0.0;
        explained = explained && column.explained;
      }
    }
    return explained;
  }

  void weigh_chunk(std::size_t chunk, std::uint32_t slots, std::uint32_t round) {
    for (Column& column : columns_) {
      if (!column.explained) column.sums[chunk] = 0.0;
    }
    const auto first = static_cast<std::uint32_t>(chunk) * kChunk;
    for (std::uint32_t i = first; i < std::min(first + kChunk, slots); ++i) {
      if (round == 0) next_[i] = {now_[i].fixed, U::visible(latest_.seen)};
      PhiloxDraws draws(key_, scenario(i, round), step_ + 1);
      for (int unit = 0; unit < U::kUnits; ++unit) {
        Column& column = columns_[unit];
        if (column.explained || i >= column.count) continue;
        const double factor = advance(unit, i, round, draws);
        column.next_likelihoods[i] = column.starts_again ? PathLikelihood{} : column.likelihoods[i];
        column.next_likelihoods[i].multiply(factor);
        column.next_weights[i] = (column.starts_again ? 1.0 : column.weights[i]) * factor;
        column.sums[chunk] += column.next_weights[i];
      }
    }
  }

  // Moves a unit of one particle. Where all particles contradict what was seen first, others start elsewhere.
  double advance(int unit, std::uint32_t i, std::uint32_t round, PhiloxDraws& draws) {
    Particle& to = next_[i];
    if (!columns_[unit].starts_again && (round == 0 || step_ > 0 || U::kSeesFirst)) {
      if ((U::kRedraws || U::kMovesValues) && round > 0) {
        redraw(unit, i, now_[i], draws);
        if constexpr (U::kMovesValues) move_values(i, draws, kValueMoves);
        U::copy(unit, now_[i].fixed, now_[i].state, to.fixed, to.state);
      }
      return U::move(params_, to.fixed, now_[i].state, latest_.action, latest_.seen, draws, unit, to.state);
    }
    Particle from{fixed_, starts_[unit]};
    PhiloxDraws start(key_, scenario(i, round), step_);
    U::draw(params_, start, unit, from.fixed, from.state);
    U::copy(unit, from.fixed, from.state, to.fixed, to.state);
    return U::move(params_, to.fixed, from.state, latest_.action, latest_.seen, draws, unit, to.state);
  }

  // Takes the new weights of a unit, and chooses the particles to copy if it has to be resampled.
  void take_weights(int unit) {
    Column& column = columns_[unit];
    if (column.explained) {
      column.note_surprise();
      column.take_weights();
    }
    if (column.starts_again) {
      column.born = step_ - 1;
      column.start_weighed = false;
      column.past.clear();
    }
    if (column.starts_again || (column.round > 0 && step_ == 1 && !U::kSeesFirst)) {
      lost_starts_ = true;
      for (std::uint32_t i = 0; i < column.count; ++i) {
        column.origins[i] = scenario(i, column.round);
        column.names.draw(PhiloxDraws(key_, column.origins[i], column.born), column.words_of(i));
      }
    }
    if (column.can_move() && column.born + column.past.size() < past_.size())
      column.past.add(column.round, column.explained);
    count_values(unit, next_);
    const bool repeats = column.repeats();
    const double lost = column.lost();
    column.resampled = column.effective_size() < 0.5 * static_cast<double>(column.count);
    if (column.resampled) resample(unit);
    plan_moves(column, repeats || step_ == column.born + 1, lost);
  }

  void resample(int unit) {
    Column& column = columns_[unit];
    const std::uint32_t word =
        PhiloxDraws(key_, static_cast<std::uint32_t>(unit), step_).word(kResampleSite, 0);
    column.pick(word, column.count);
    if (least() < most_) column.pick(word, wanted_count(unit));
    column.copy_picks();
    if (column.can_move() && column.born + column.past.size() == step_)
      column.past.back().parents = column.picks;
  }

  // The number of particles for as many values, coarsely, as those chosen have: the size that KLD sampling asks
  // for is nearly proportional to that.
  std::uint32_t wanted_count(int unit) {
    Column& column = columns_[unit];
    ValueSet& cells = column.found;
    cells.clear(column.count);
    double values[U::kValues + 1];
    for (std::size_t i = 0; i < column.picks.size(); ++i) {
      if (i > 0 && column.picks[i] == column.picks[i - 1]) continue;
      const Particle& particle = next_[column.picks[i]];
      const int count = U::values(unit, particle.fixed, particle.state, values);
      cells.add(column.scale.cell(values, count));
    }
    const double share = static_cast<double>(cells.size()) / kManyValues;
    const auto wanted = static_cast<std::uint32_t>(std::min(1.0, share) * static_cast<double>(most_));
    return std::max(wanted, least());
  }

  // Copies the particles that resampling has chosen. `before`: slots in use before.
  void gather(std::uint32_t before) {
    bool any = false;
    for (const Column& column : columns_) any = any || column.resampled;
    if (!any) return;
    resampled_ = true;
    for_slots(std::max(before, largest()), [&](std::uint32_t i) {
      next_[i] = i < before ? now_[i] : Particle{fixed_, U::visible(latest_.seen)};
      for (int unit = 0; unit < U::kUnits; ++unit) {
        const Column& column = columns_[unit];
        if (!column.resampled || i >= column.count) continue;
        const Particle& from = now_[column.picks[i]];
        U::copy(unit, from.fixed, from.state, next_[i].fixed, next_[i].state);
        redraw(unit, i, next_[i], PhiloxDraws(key_, i, step_));
      }
    });
    now_.swap(next_);
  }

  // Moves of particles ------------------------------------------------------------------------------------

  // How many moves a unit makes. None where the model's own noise has told all copies apart by the next step. A
  // longer past allows fewer, so that all steps take about as long.
  void plan_moves(Column& column, bool pays, [[maybe_unused]] double lost) {
    pays = pays && column.can_move() && column.born + column.past.size() == step_;
    const std::uint32_t wanted = U::kMovesValues
                                     ? static_cast<std::uint32_t>(lost * kValueMoves * column.count)
                                     : kReplays * column.count / (step_ - column.born);
    column.moves = pays ? std::max(1U, wanted) : 0;
  }

  // How many of a unit's moves are for a slot. Over the steps all slots have their turn.
  std::uint32_t moves_of(const Column& column, std::uint32_t i) const {
    const std::uint64_t count = column.count, rest = column.moves % count;
    return static_cast<std::uint32_t>(column.moves / count + ((i + step_) * rest % count < rest ? 1 : 0));
  }

  void rejuvenate(int unit, std::uint32_t i) {
    Column& column = columns_[unit];
    if (column.moves == 0 || i >= column.count || !(column.weights[i] > 0.0)) return;
    const std::uint32_t moves = moves_of(column, i);
    if (moves == 0) return;
    std::uint32_t names[kLongestPast];
    trace_back(column, i, names);
    PhiloxDraws draws(key_, i, step_);
    std::uint32_t words[U::kFirstWords];
    for (std::uint32_t move = 0; move < moves; ++move) {
      const std::uint32_t number = static_cast<std::uint32_t>(unit) * kReplays + move;
      WordMove proposal(draws, kMoveSite, number * WordMove::kWords);
      proposal.propose(column.names, column.words_of(i), words);
      Particle other{fixed_, starts_[unit]};
      PathLikelihood likelihood;
      if (!replay(unit, column.origins[i], names, words, proposal.threshold(), column.likelihoods[i], other,
                  likelihood))
        continue;
      U::copy(unit, other.fixed, other.state, now_[i].fixed, now_[i].state);
      column.likelihoods[i] = likelihood;
      std::copy_n(words, column.names.size(), column.words_of(i));
    }
  }

  // Moves values of a particle. Two tests accept a move, one after the other, and each leaves its own factor of the
  // posterior as it is (delayed acceptance; Christen and Fox, 2005). The first one mostly ends early.
  void move_values(std::uint32_t i, PhiloxDraws draws, std::uint32_t moves) {
    Column& column = columns_[0];
    if (moves == 0 || i >= column.count || !(column.weights[i] > 0.0) || !column.can_move() ||
        column.past.size() != step_)
      return;
    double density = -1.0;  // of the particle's values; below 0: not known
    for (std::uint32_t number = 0; number < moves; ++number) {
      typename U::Move move(draws, kMoveSite, number * U::Move::kWords);
      Fixed fixed = now_[i].fixed;
      PathLikelihood likelihood;
      if (!move.propose(fixed.values) ||
          !weigh_past(fixed, move.likelihood_share(), column.likelihoods[i], likelihood))
        continue;
      if (density < 0.0) density = U::start_density(params_, now_[i].fixed, starts_[0]);
      const double other = U::start_density(params_, fixed, starts_[0]);
      if (!(other > move.density_share() * density)) continue;
      density = other;
      now_[i].fixed = fixed;
      column.likelihoods[i] = likelihood;
    }
  }

  // How likely values make all that was seen. Gives false as `replay` does.
  bool weigh_past(const Fixed& fixed, double share, const PathLikelihood& least,
                  PathLikelihood& likelihood) const {
    const Column& column = columns_[0];
    if (column.start_weighed) likelihood.multiply(U::weigh_start(params_, 0, fixed, starts_[0]));
    for (std::size_t s = 0; s < column.past.size(); ++s) {
      if (!column.past[s].weighed) continue;
      const Step& step = past_[s];
      likelihood.multiply(U::weigh(params_, fixed, step.before, step.action, step.seen));
      if (!likelihood.exceeds(share, least)) return false;
    }
    return likelihood.exceeds(share, least);
  }

  // Finds the scenarios whose names a particle has drawn with in each step.
  void trace_back(const Column& column, std::uint32_t i, std::uint32_t* names) const {
    for (std::size_t s = column.past.size(); s-- > 0;) {
      const Descent& descent = column.past[s];
      if (!descent.parents.empty()) i = descent.parents[i];
      names[s] = scenario(i, descent.round);
    }
  }

  // Runs a unit's past again from other first words. Gives false as soon as the path cannot be likelier than
  // `share` of `least` any more: no factor is above 1.
  bool replay(int unit, std::uint32_t origin, const std::uint32_t* names, const std::uint32_t* words,
              double share, const PathLikelihood& least, Particle& particle,
              PathLikelihood& likelihood) const {
    const Column& column = columns_[unit];
    draw(unit, origin, words, particle);
    if (column.start_weighed) {
      likelihood.multiply(U::weigh_start(params_, unit, particle.fixed, particle.state));
      if (!likelihood.exceeds(share, least)) return false;
    }
    for (std::size_t s = 0; s < column.past.size(); ++s) {
      const Step& step = past_[column.born + s];
      PhiloxDraws draws(key_, names[s], column.born + static_cast<std::uint32_t>(s) + 1);
      State next = U::visible(step.seen);
      const double factor =
          U::move(params_, particle.fixed, particle.state, step.action, step.seen, draws, unit, next);
      particle.state = next;
      if (!column.past[s].weighed) continue;
      likelihood.multiply(factor);
      if (!likelihood.exceeds(share, least)) return false;
    }
    return true;
  }

  Workers* workers_ = nullptr;
  std::uint32_t step_ = 0;
  bool resampled_ = false;
  std::atomic<bool> lost_starts_{false};  // units are taken at the same time
  Step latest_{};
  std::vector<Step> past_;
  std::vector<Particle> now_, next_;
};

}  // namespace hypgen
