// SPDX-License-Identifier: Apache-2.0
// The words of a search, each computed once.
//
// A search draws the same words again and again: they depend on scenario, step and site, not on the action or
// the node.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hypgen/random/philox.hpp"

namespace hypgen {

// Words by scenario and step. A site is computed for a run of steps at once, which compilers turn into vector
// code. A few sites have room for each scenario; `find` gives null for the others, and for later steps than
// the cache is made for.
class DrawCache {
  static constexpr std::uint32_t kRun = 16;
  static constexpr std::uint32_t kWays = 4;

 public:
  // A run of words of one site.
  struct Slot {
    std::uint32_t search;
    std::uint32_t site;
    std::uint32_t index;
    std::uint32_t words[kRun];
  };

  DrawCache(std::size_t scenarios, std::size_t steps)
      : runs_((steps + kRun - 1) / kRun), slots_(scenarios * runs_ * kWays) {}

  static std::size_t bytes(std::size_t scenarios, std::size_t steps) {
    return (steps + kRun - 1) / kRun * kWays * scenarios * sizeof(Slot);
  }

  // How many of `steps` a cache of so many bytes can be made for.
  static std::size_t steps_within(std::size_t bytes, std::size_t scenarios, std::size_t steps) {
    return std::min(steps, bytes / (kWays * scenarios * sizeof(Slot)) * kRun);
  }

  // Forgets all words. Scenario i draws under the number `first + i`.
  void begin_search(StreamKey key, std::uint32_t first) {
    key_ = key;
    first_ = first;
    if (++search_ != 0) return;
    for (Slot& slot : slots_) slot.search = 0;
    search_ = 1;
  }

  // Where the words of a scenario's step are kept; null if the cache is not made for it.
  Slot* slots_for(std::uint32_t scenario, std::uint32_t step) {
    return step / kRun < runs_ ? &slots_[(scenario * runs_ + step / kRun) * kWays] : nullptr;
  }

  // `slots` are those of the scenario's step.
  const std::uint32_t* find(Slot* slots, std::uint32_t scenario, std::uint32_t step, std::uint32_t site,
                            std::uint32_t index) {
    const std::uint32_t way = (site ^ site >> 16) + index;
    for (std::uint32_t probe = 0; probe < 2; ++probe) {
      Slot& slot = slots[(way ^ probe) % kWays];
      if (slot.search != search_) fill(slot, scenario, step, site, index);
      if (slot.site == site && slot.index == index) return &slot.words[step % kRun];
    }
    return nullptr;
  }

  StreamKey key() const { return key_; }
  std::uint32_t first() const { return first_; }

 private:
  void fill(Slot& slot, std::uint32_t scenario, std::uint32_t step, std::uint32_t site, std::uint32_t index) {
    slot.search = search_;
    slot.site = site;
    slot.index = index;
    const std::uint32_t start = step - step % kRun;
    for (std::uint32_t i = 0; i < kRun; ++i) {
      slot.words[i] =
          philox(key_.key0, key_.key1, {{first_ + scenario, start + i, site, index / 4}}).words[index % 4];
    }
  }

  std::size_t runs_;
  StreamKey key_{};
  std::uint32_t first_ = 0;
  std::uint32_t search_ = 0;
  std::vector<Slot> slots_;
};

// The draws of one scenario in one step of a search: the same words as PhiloxDraws gives.
class SearchDraws {
 public:
  SearchDraws(DrawCache& cache, std::uint32_t scenario, std::uint32_t step)
      : cache_(cache),
        slots_(cache.slots_for(scenario, step)),
        scenario_(scenario),
        step_(step),
        uncached_(cache.key(), cache.first() + scenario, step) {}

  std::uint32_t word(std::uint32_t site, std::uint32_t index) {
    if (slots_ != nullptr) {
      const std::uint32_t* const found = cache_.find(slots_, scenario_, step_, site, index);
      if (found != nullptr) return *found;
    }
    return uncached_.word(site, index);
  }

  std::uint32_t second_word(std::uint32_t site, std::uint32_t index) const {
    return uncached_.second_word(site, index);
  }

 private:
  DrawCache& cache_;
  DrawCache::Slot* slots_;
  std::uint32_t scenario_;
  std::uint32_t step_;
  PhiloxDraws uncached_;
};

inline std::uint32_t second_word(SearchDraws& draws, std::uint32_t site, std::uint32_t index) {
  return draws.second_word(site, index);
}

}  // namespace hypgen
