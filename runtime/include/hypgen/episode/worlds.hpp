// SPDX-License-Identifier: Apache-2.0
// Many worlds of a model beside each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "hypgen/core/config.hpp"
#include "hypgen/core/status.hpp"
#include "hypgen/episode/world.hpp"

namespace hypgen {

// Where a step of many worlds writes: an entry or a row for each of them. Null: not wanted.
struct WorldsResults {
  double* rewards = nullptr;         // NaN where the model's reward is no number
  std::int32_t* seen = nullptr;      // the values of the keys
  std::uint64_t* keys = nullptr;     // of what was seen; zeroes where nothing was
  std::int32_t* visible = nullptr;   // after the step
  std::uint8_t* legal = nullptr;     // for each action: whether it is allowed next
  std::uint8_t* terminal = nullptr;  // whether the step has ended the episode
  std::uint8_t* success = nullptr;
};

// Worlds beside each other, each in an episode of its own: one call for all of them. A call gives kNoGpu and `error`
// if a GPU that they are on has failed; they are of no use then.
class Worlds {
 public:
  // In place of an action: the world's next episode starts.
  static constexpr std::int32_t kNextEpisode = std::numeric_limits<std::int32_t>::min();
  static constexpr std::uint64_t kMostEpisodes = std::uint64_t{1}
                                                 << 32;  // the draws' names have 32 bits for it

  virtual ~Worlds() = default;

  // Ends all episodes. Later ones draw by this seed, and are numbered afresh: world i of n plays i, i + n, ...
  virtual Status reseed(std::uint64_t seed, std::string& error) = 0;

  // Episodes that begin later start with these values, and draw the others.
  virtual Status set_start(StartValues start, std::string& error) = 0;

  // Starts an episode in each world whose entry of `mask` is not 0; null: in all. `episodes` has the number for
  // each world, from which its next ones count on; null: the next ones. kWrongArgument: nothing has started, as
  // `refused` is the first world without a number below kMostEpisodes.
  virtual Status reset(const std::uint8_t* mask, const std::uint64_t* episodes, std::size_t& refused,
                       std::string& error) = 0;

  virtual Status export_visible(std::int32_t* out, std::string& error) = 0;

  // Writes 1 for each action of each world that is allowed; none is where no episode is under way.
  virtual Status export_legal(std::uint8_t* out, std::string& error) = 0;

  // Does an action in each world. kModelNan: a reward is no number. kWrongArgument: nothing has moved, as `refused`
  // is the first world that cannot do its action.
  virtual Status step(const std::int32_t* actions, const WorldsResults& out, std::size_t& refused,
                      std::string& error) = 0;
};

// What may go wrong in a step of a world.
constexpr std::uint32_t kRewardFault = 1;  // the reward is no number
constexpr std::uint32_t kKeyFault = 2;     // the model has made a key that has no values

// One of many worlds.
template <class M>
struct OneWorld {
  SimulatedEpisode<M> episode;
  std::uint64_t next = 0;  // the number of its next episode
  bool is_playing = false;
};

// What each call does in one world, `i`: the CPU has a loop over the worlds, and a GPU a thread for each.
template <class M>
struct WorldsPlay {
  const typename M::Params* params = nullptr;
  OneWorld<M>* worlds = nullptr;
  std::size_t count = 0;
  StreamKey key{};
  StartView start{};
  const KeyDigit* digits = nullptr;
  std::size_t digit_count = 0;

  HYPGEN_FN void seed(std::size_t i) const {
    worlds[i].next = i;
    worlds[i].is_playing = false;
  }

  HYPGEN_FN bool can_begin(std::size_t i, const std::uint8_t* mask, const std::uint64_t* episodes) const {
    if (mask != nullptr && mask[i] == 0) return true;
    return (episodes != nullptr ? episodes[i] : worlds[i].next) < Worlds::kMostEpisodes;
  }

  HYPGEN_FN void reset(std::size_t i, const std::uint8_t* mask, const std::uint64_t* episodes) const {
    if (mask != nullptr && mask[i] == 0) return;
    if (episodes != nullptr) worlds[i].next = episodes[i];
    begin(worlds[i]);
  }

  HYPGEN_FN bool can_do(std::size_t i, std::int32_t action) const {
    const OneWorld<M>& world = worlds[i];
    if (action == Worlds::kNextEpisode) return world.next < Worlds::kMostEpisodes;
    return world.is_playing && action >= 0 && action < M::kActionCount &&
           M::is_legal(*params, world.episode.fixed, world.episode.state, action);
  }

  // Returns the step's faults.
  HYPGEN_FN std::uint32_t step(std::size_t i, std::int32_t action, const WorldsResults& out) const {
    OneWorld<M>& world = worlds[i];
    typename M::Key seen{};
    StepResult result{};
    if (action == Worlds::kNextEpisode) {
      begin(world);
    } else {
      result = world.episode.step(*params, key, action, seen);
      world.is_playing = !result.terminal;
    }
    const bool is_known = !is_broken<M>(result);
    std::uint32_t faults = is_known ? 0 : kRewardFault;
    if (out.rewards != nullptr)
      out.rewards[i] =
          is_known ? from_fixed_sum<kRewardBits<M>>(result.reward) : std::numeric_limits<double>::quiet_NaN();
    const KeyWords words = words_of(seen);
    if (out.keys != nullptr) {
      for (std::size_t w = 0; w < words.size(); ++w) out.keys[i * words.size() + w] = words[w];
    }
    if (out.seen != nullptr && !decode_key(digits, digit_count, words, out.seen + i * digit_count))
      faults |= kKeyFault;
    show(i, out);
    if (out.terminal != nullptr) out.terminal[i] = result.terminal ? 1 : 0;
    if (out.success != nullptr) out.success[i] = result.success ? 1 : 0;
    return faults;
  }

  // Writes what is visible and which actions are allowed, if wanted.
  HYPGEN_FN void show(std::size_t i, const WorldsResults& out) const {
    const OneWorld<M>& world = worlds[i];
    if (out.visible != nullptr) {
      M::export_visible(world.episode.fixed, world.episode.state,
                        out.visible + i * static_cast<std::size_t>(M::kVisibleCount));
    }
    if (out.legal == nullptr) return;
    std::uint8_t* const row = out.legal + i * static_cast<std::size_t>(M::kActionCount);
    // Copies, as a byte that is written may lie anywhere for all that the compiler knows.
    const typename M::Fixed fixed = world.episode.fixed;
    const typename M::State state = world.episode.state;
    const bool is_playing = world.is_playing;
    for (int action = 0; action < M::kActionCount; ++action)
      row[action] = is_playing && M::is_legal(*params, fixed, state, action) ? 1 : 0;
  }

 private:
  HYPGEN_FN void begin(OneWorld<M>& world) const {
    world.episode.begin(*params, key, world.next, start);
    world.next += count;
    world.is_playing = true;
  }
};

// What a step's faults come to.
inline Status status_of(std::uint32_t faults, std::string& error) {
  if ((faults & kKeyFault) == 0) return faults == 0 ? Status::kOk : Status::kModelNan;
  error = "the model has made a key that has no values";
  return Status::kWrongArgument;
}

// On the CPU, in the thread that calls.
template <class M>
class ModelWorlds final : public Worlds {
 public:
  ModelWorlds(const typename M::Params& params, std::uint64_t seed, std::size_t count,
              std::vector<KeyDigit> digits)
      : worlds_(count), digits_(std::move(digits)) {
    play_.params = &params;
    play_.worlds = worlds_.data();
    play_.count = count;
    play_.digits = digits_.data();
    play_.digit_count = digits_.size();
    begin_stream(seed);
  }

  Status reseed(std::uint64_t seed, std::string&) override {
    begin_stream(seed);
    return Status::kOk;
  }

  Status set_start(StartValues start, std::string&) override {
    start_ = std::move(start);
    play_.start = start_.view();
    return Status::kOk;
  }

  Status reset(const std::uint8_t* mask, const std::uint64_t* episodes, std::size_t& refused,
               std::string&) override {
    refused = first_that([&](std::size_t i) { return !play_.can_begin(i, mask, episodes); });
    if (refused < play_.count) return Status::kWrongArgument;
    for (std::size_t i = 0; i < play_.count; ++i) play_.reset(i, mask, episodes);
    return Status::kOk;
  }

  Status export_visible(std::int32_t* out, std::string&) override {
    WorldsResults results;
    results.visible = out;
    return show(results);
  }

  Status export_legal(std::uint8_t* out, std::string&) override {
    WorldsResults results;
    results.legal = out;
    return show(results);
  }

  Status step(const std::int32_t* actions, const WorldsResults& out, std::size_t& refused,
              std::string& error) override {
    refused = first_that([&](std::size_t i) { return !play_.can_do(i, actions[i]); });
    if (refused < play_.count) return Status::kWrongArgument;
    std::uint32_t faults = 0;
    for (std::size_t i = 0; i < play_.count; ++i) faults |= play_.step(i, actions[i], out);
    return status_of(faults, error);
  }

 private:
  void begin_stream(std::uint64_t seed) {
    play_.key = derive(seed, StreamKind::kWorld, 0);
    for (std::size_t i = 0; i < play_.count; ++i) play_.seed(i);
  }

  // The number of worlds if none is found.
  template <class Holds>
  std::size_t first_that(const Holds& holds) const {
    std::size_t i = 0;
    while (i < play_.count && !holds(i)) ++i;
    return i;
  }

  Status show(const WorldsResults& out) const {
    for (std::size_t i = 0; i < play_.count; ++i) play_.show(i, out);
    return Status::kOk;
  }

  std::vector<OneWorld<M>> worlds_;
  std::vector<KeyDigit> digits_;
  StartValues start_;
  WorldsPlay<M> play_;
};

}  // namespace hypgen
