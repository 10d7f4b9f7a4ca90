// SPDX-License-Identifier: Apache-2.0
// Random words as a function of names: Philox4x32-10 (Salmon et al., SC 2011) and the streams derived from a
// seed.
#pragma once

#include <cstdint>

#include "hypgen/core/config.hpp"

namespace hypgen {

// Four random words.
struct PhiloxBlock {
  std::uint32_t words[4];
};

// Philox4x32 with 10 rounds.
HYPGEN_FN PhiloxBlock philox(std::uint32_t key0, std::uint32_t key1, PhiloxBlock counter) {
  constexpr std::uint64_t kMultiplier0 = 0xD2511F53, kMultiplier1 = 0xCD9E8D57;
  constexpr std::uint32_t kWeyl0 = 0x9E3779B9, kWeyl1 = 0xBB67AE85;
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t product0 = kMultiplier0 * counter.words[0];
    const std::uint64_t product1 = kMultiplier1 * counter.words[2];
    counter = {{static_cast<std::uint32_t>(product1 >> 32) ^ counter.words[1] ^ key0,
                static_cast<std::uint32_t>(product1),
                static_cast<std::uint32_t>(product0 >> 32) ^ counter.words[3] ^ key1,
                static_cast<std::uint32_t>(product0)}};
    key0 += kWeyl0;
    key1 += kWeyl1;
  }
  return counter;
}

// Who draws. A planner never shares the world's stream.
enum class StreamKind : std::uint32_t { kWorld = 0, kBelief = 1, kPlan = 2, kTest = 3 };

// The key of one stream.
struct StreamKey {
  std::uint32_t key0;
  std::uint32_t key1;
};

// The key of stream `number` of a kind.
HYPGEN_FN StreamKey derive(std::uint64_t seed, StreamKind kind, std::uint64_t number) {
  const PhiloxBlock block = philox(static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                                   {{static_cast<std::uint32_t>(kind), static_cast<std::uint32_t>(number),
                                     static_cast<std::uint32_t>(number >> 32), 0x68797067}});
  return {block.words[0], block.words[1]};
}

// Draw number 2^20 run + step of the plan streams.
HYPGEN_FN std::uint64_t plan_number(std::uint64_t run, std::uint64_t step) { return (run << 20) + step; }

// In the index of a draw's second word (random/fine_words.hpp). No draw has so many members.
inline constexpr std::uint32_t kSecondWord = std::uint32_t{1} << 31;

// The draws of one scenario in one step. Keeps its latest block, as members of a family share blocks, and
// every action of a step draws the same words.
class PhiloxDraws {
 public:
  HYPGEN_FN PhiloxDraws(StreamKey key, std::uint32_t scenario, std::uint32_t step)
      : key_(key), scenario_(scenario), step_(step) {}

  HYPGEN_FN std::uint32_t word(std::uint32_t site, std::uint32_t index) {
    const std::uint32_t block = index / 4;
    if (!cached_ || site != site_ || block != block_) {
      words_ = philox(key_.key0, key_.key1, {{scenario_, step_, site, block}});
      site_ = site;
      block_ = block;
      cached_ = true;
    }
    return words_.words[index % 4];
  }

  // The second word of a draw; it leaves the kept block alone.
  HYPGEN_FN std::uint32_t second_word(std::uint32_t site, std::uint32_t index) const {
    return apart(key_, scenario_, step_, site, index | kSecondWord);
  }

 private:
  // Takes values, as the address of the draws would keep them out of registers.
  HYPGEN_COLD_FN static std::uint32_t apart(StreamKey key, std::uint32_t scenario, std::uint32_t step,
                                            std::uint32_t site, std::uint32_t index) {
    return philox(key.key0, key.key1, {{scenario, step, site, index / 4}}).words[index % 4];
  }

  StreamKey key_;
  std::uint32_t scenario_;
  std::uint32_t step_;
  std::uint32_t site_ = 0;
  std::uint32_t block_ = 0;
  bool cached_ = false;
  PhiloxBlock words_;
};

// The second word of a draw, from any source.
template <class D>
HYPGEN_FN auto second_word(D& draws, std::uint32_t site, std::uint32_t index) {
  return draws.word(site, index | kSecondWord);
}
HYPGEN_FN std::uint32_t second_word(PhiloxDraws& draws, std::uint32_t site, std::uint32_t index) {
  return draws.second_word(site, index);
}

// Draws from a list, in the order of the calls; starts again at its end. For tests.
class RecordedDraws {
 public:
  RecordedDraws(const std::uint32_t* words, std::uint32_t count) : words_(words), count_(count) {}

  std::uint32_t word(std::uint32_t /*site*/, std::uint32_t /*index*/) { return words_[next_++ % count_]; }

 private:
  const std::uint32_t* words_;
  std::uint32_t count_;
  std::uint32_t next_ = 0;
};

// The id of one of the runtime's own draw sites: FNV-1a of its path, as for a model's sites. The compiler
// gives these ids to no site of a model.
constexpr std::uint32_t site_id(const char* path) {
  std::uint32_t id = 0x811C9DC5;
  for (; *path != '\0'; ++path) id = (id ^ static_cast<unsigned char>(*path)) * 0x01000193;
  return id;
}

}  // namespace hypgen
