// SPDX-License-Identifier: Apache-2.0
// The data that the workers of an evaluator on the host share, and the memory of each worker.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hypgen/leaves/draw_cache.hpp"
#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/leaves/rollout.hpp"
#include "hypgen/leaves/weighted_groups.hpp"
#include "hypgen/memory/chunk_pool.hpp"

namespace hypgen {

// A member of a node: a scenario and its state there.
template <class M>
struct CpuMember {
  std::uint32_t scenario;  // index into CpuScene::fixed
  typename M::State state;
};

// An expanded node, with its members behind it in one block. The worker that expands the node writes it once.
// Any worker reads it to find the members of a child.
template <class M>
struct CpuNode {
  typename M::History history;
  std::uint32_t count;  // of members

  static std::size_t bytes(std::size_t count) { return members_at() + count * sizeof(CpuMember<M>); }
  CpuMember<M>* members() {
    return reinterpret_cast<CpuMember<M>*>(reinterpret_cast<unsigned char*>(this) + members_at());
  }

 private:
  static constexpr std::size_t members_at() {
    return (sizeof(CpuNode) + alignof(CpuMember<M>) - 1) / alignof(CpuMember<M>) * alignof(CpuMember<M>);
  }
};

// The outcome of one action for one scenario of the leaf in work.
template <class M>
struct CpuOutcome {
  std::int64_t reward;
  typename M::Key key;
  ScenarioBounds bounds;
  bool terminal;

  static constexpr std::size_t kHistoryBytes =
      M::kHasHistory ? sizeof(typename M::History) + sizeof(std::uint32_t) : 0;
};

// The sizes of a worker's scratch memory, besides rows. With little memory a worker holds fewer outcomes at
// once; with less still it caches the draws of fewer steps.
template <class M>
struct CpuScratch {
  std::size_t outcomes;  // held at once: more actions than fit are simulated in blocks
  std::size_t cached_steps;

  // The sizes that fit into `bytes`, or the least that work if `bytes` are fewer.
  static CpuScratch within(std::size_t bytes, const EvaluatorOptions& options) {
    const std::size_t scenarios = options.max_scenarios, actions = M::kActionCount;
    const std::size_t most = std::max(scenarios, std::min(scenarios * actions, kMostOutcomeBytes / kOutcome));
    const auto all_steps = static_cast<std::size_t>(options.max_depth) + 1;
    const std::size_t rest = bytes - std::min(bytes, least_bytes(options));
    const std::size_t cached_steps = DrawCache::steps_within(rest, scenarios, all_steps);
    if (cached_steps < all_steps) return {scenarios, cached_steps};
    const std::size_t more = (rest - DrawCache::bytes(scenarios, all_steps)) / kOutcome;
    return {std::min(most, scenarios + more), all_steps};
  }

  std::size_t bytes(const EvaluatorOptions& options) const {
    return least_bytes(options) + (outcomes - options.max_scenarios) * kOutcome +
           DrawCache::bytes(options.max_scenarios, cached_steps);
  }

  static std::size_t least_bytes(const EvaluatorOptions& options) {
    constexpr std::size_t kGroupingSlots = 4;  // a scenario, at most
    constexpr std::size_t kScenario = sizeof(CpuMember<M>) + kOutcome + sizeof(std::int64_t) +
                                      kGroupingSlots * (sizeof(typename M::Key) + 2 * sizeof(std::uint32_t));
    const std::size_t weighted = options.may_weigh ? kWeightedBytes : 0;
    const std::size_t waiting = options.lanes != nullptr ? RolloutQueue<M>::bytes() : 0;
    return options.max_scenarios * (kScenario + weighted) + waiting +
           M::kActionCount * (sizeof(ActionRow) + sizeof(Gain));
  }

 private:
  static constexpr std::size_t kMostOutcomeBytes = std::size_t{20} << 20;  // more is not faster
  static constexpr std::size_t kWeightedBytes =
      WeightedGroups<M>::kScenarioBytes + sizeof(typename M::State) + sizeof(typename M::History);
  static constexpr std::size_t kOutcome = sizeof(CpuOutcome<M>) + CpuOutcome<M>::kHistoryBytes;
};

// The evaluator writes it while no worker is at work. Only the pool changes during a search.
template <class M>
struct CpuScene {
  const typename M::Params& params;
  EvaluatorOptions options;
  std::size_t threads;                   // that have a worker
  CpuScratch<M> scratch;                 // of each
  std::vector<typename M::Fixed> fixed;  // of the root's scenarios
  ChunkPool pool;                        // nodes, and rows of leaves
  SearchSetup setup{};
  Ref<CpuNode<M>> root{};

  CpuScene(const typename M::Params& model_params, const EvaluatorOptions& evaluator_options)
      : params(model_params),
        options(evaluator_options),
        threads(std::clamp<std::size_t>(most_scratch() / CpuScratch<M>::least_bytes(options), 1,
                                        std::max<std::size_t>(1, options.threads))),
        scratch(CpuScratch<M>::within(most_scratch() / threads, options)),
        fixed(options.max_scenarios),
        pool(pool_bytes(), threads) {}

 private:
  // The most scratch memory of all workers together.
  std::size_t most_scratch() const { return options.memory_bytes / 4; }

  std::size_t pool_bytes() const {
    const std::size_t apart = std::min(most_scratch(), threads * scratch.bytes(options));
    return std::max(options.memory_bytes - apart, root_bytes());
  }

  // The bytes that an expansion of the root takes at most.
  std::size_t root_bytes() const {
    const std::size_t rows = sizeof(ActionRow) + sizeof(Gain) + options.max_scenarios * sizeof(ChildRow);
    return CpuNode<M>::bytes(options.max_scenarios) + M::kActionCount * rows + kCacheLine;
  }
};

}  // namespace hypgen
