// SPDX-License-Identifier: Apache-2.0
// Many worlds of a model beside each other.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "hypgen/episode/world.hpp"

namespace hypgen {

// Where a step of many worlds writes: an entry or a row for each of them. Null: not wanted.
struct WorldsResults {
  double* rewards = nullptr;         // NaN where the model's reward is no number
  std::uint64_t* keys = nullptr;     // of what was seen; zeroes where nothing was
  std::int32_t* visible = nullptr;   // after the step
  std::uint8_t* legal = nullptr;     // for each action: whether it is allowed next
  std::uint8_t* terminal = nullptr;  // whether the step has ended the episode
  std::uint8_t* success = nullptr;
};

// Worlds beside each other, each in an episode of its own: one call for all of them.
class Worlds {
 public:
  // In place of an action: the world's next episode starts.
  static constexpr std::int32_t kNextEpisode = std::numeric_limits<std::int32_t>::min();
  static constexpr std::uint64_t kMostEpisodes = std::uint64_t{1}
                                                 << 32;  // the draws' names have 32 bits for it

  virtual ~Worlds() = default;

  // Ends all episodes. Later ones draw by this seed, and are numbered afresh: world i of n plays i, i + n, ...
  virtual void reseed(std::uint64_t seed) = 0;

  // Episodes that begin later start with these values, and draw the others.
  virtual void set_start(StartValues start) = 0;

  // Starts an episode in each world whose entry of `mask` is not 0; null: in all. `episodes` has the number for
  // each world, from which its next ones count on; null: the next ones.
  virtual void reset(const std::uint8_t* mask, const std::uint64_t* episodes) = 0;

  // The number of the next episode of a world.
  virtual std::uint64_t next_episode(std::size_t world) const = 0;

  virtual void export_visible(std::int32_t* out) const = 0;

  // Writes 1 for each action of each world that is allowed; none is where no episode is under way.
  virtual void export_legal(std::uint8_t* out) const = 0;

  // The number of the first world that cannot do its action; that of all worlds if each can.
  virtual std::size_t find_refusal(const std::int32_t* actions) const = 0;

  // Does an action in each world. None is refused. False if a reward is no number.
  virtual bool step(const std::int32_t* actions, const WorldsResults& out) = 0;
};

template <class M>
class ModelWorlds final : public Worlds {
 public:
  ModelWorlds(const typename M::Params& params, std::uint64_t seed, std::size_t count)
      : params_(params), worlds_(count) {
    reseed(seed);
  }

  void reseed(std::uint64_t seed) override {
    key_ = derive(seed, StreamKind::kWorld, 0);
    for (std::size_t i = 0; i < worlds_.size(); ++i) {
      worlds_[i].next = i;
      worlds_[i].is_playing = false;
    }
  }

  void set_start(StartValues start) override { start_ = std::move(start); }

  void reset(const std::uint8_t* mask, const std::uint64_t* episodes) override {
    for (std::size_t i = 0; i < worlds_.size(); ++i) {
      if (mask != nullptr && mask[i] == 0) continue;
      if (episodes != nullptr) worlds_[i].next = episodes[i];
      begin(worlds_[i]);
    }
  }

  std::uint64_t next_episode(std::size_t world) const override { return worlds_[world].next; }

  void export_visible(std::int32_t* out) const override {
    for (std::size_t i = 0; i < worlds_.size(); ++i) export_visible(i, out);
  }

  void export_legal(std::uint8_t* out) const override {
    for (std::size_t i = 0; i < worlds_.size(); ++i) export_legal(i, out);
  }

  std::size_t find_refusal(const std::int32_t* actions) const override {
    std::size_t i = 0;
    while (i < worlds_.size() &&
           (actions[i] == kNextEpisode ? worlds_[i].next < kMostEpisodes : can_do(worlds_[i], actions[i])))
      ++i;
    return i;
  }

  bool step(const std::int32_t* actions, const WorldsResults& out) override {
    bool has_rewards = true;
    for (std::size_t i = 0; i < worlds_.size(); ++i) {
      OneWorld& world = worlds_[i];
      typename M::Key seen{};
      StepResult result{};
      if (actions[i] == kNextEpisode) {
        begin(world);
      } else {
        result = world.episode.step(params_, key_, actions[i], seen);
        world.is_playing = !result.terminal;
      }
      const bool is_known = !is_broken<M>(result);
      has_rewards = has_rewards && is_known;
      if (out.rewards != nullptr)
        out.rewards[i] = is_known ? from_fixed_sum<kRewardBits<M>>(result.reward)
                                  : std::numeric_limits<double>::quiet_NaN();
      if (out.keys != nullptr) {
        const KeyWords words = words_of(seen);
        std::copy(words.begin(), words.end(), out.keys + i * words.size());
      }
      if (out.visible != nullptr) export_visible(i, out.visible);
      if (out.legal != nullptr) export_legal(i, out.legal);
      if (out.terminal != nullptr) out.terminal[i] = result.terminal ? 1 : 0;
      if (out.success != nullptr) out.success[i] = result.success ? 1 : 0;
    }
    return has_rewards;
  }

 private:
  struct OneWorld {
    SimulatedEpisode<M> episode;
    std::uint64_t next = 0;  // the number of its next episode
    bool is_playing = false;
  };

  void begin(OneWorld& world) {
    world.episode.begin(params_, key_, world.next, start_);
    world.next += worlds_.size();
    world.is_playing = true;
  }

  bool can_do(const OneWorld& world, std::int32_t action) const {
    return world.is_playing && action >= 0 && action < M::kActionCount &&
           M::is_legal(params_, world.episode.fixed, world.episode.state, action);
  }

  void export_visible(std::size_t i, std::int32_t* out) const {
    const SimulatedEpisode<M>& episode = worlds_[i].episode;
    M::export_visible(episode.fixed, episode.state, out + i * static_cast<std::size_t>(M::kVisibleCount));
  }

  void export_legal(std::size_t i, std::uint8_t* out) const {
    std::uint8_t* const row = out + i * static_cast<std::size_t>(M::kActionCount);
    for (int action = 0; action < M::kActionCount; ++action) row[action] = can_do(worlds_[i], action) ? 1 : 0;
  }

  const typename M::Params& params_;
  StreamKey key_{};
  StartValues start_;
  std::vector<OneWorld> worlds_;
};

}  // namespace hypgen
