// What the workers of one evaluator on the host share, and how much memory each takes for itself.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hypgen/leaves/draw_cache.hpp"
#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/leaves/rollout.hpp"
#include "hypgen/memory/chunk_pool.hpp"

namespace hypgen {

// A scenario at a node.
template <class M>
struct CpuMember {
  std::uint32_t scenario;  // index into CpuScene::fixed
  typename M::State state;
};

// What is kept of an expanded node, in one block: this, and its members behind it. Written once, by the
// worker that expands it; any worker reads it to find the members of a child.
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

// What a scenario came to under an action of the leaf in work.
template <class M>
struct CpuOutcome {
  std::int64_t reward;
  typename M::Key key;
  ScenarioBounds bounds;
  bool terminal;

  static constexpr std::size_t kHistoryBytes =
      M::kHasHistory ? sizeof(typename M::History) + sizeof(std::uint32_t) : 0;
};

// What a worker needs while it expands a leaf, besides rows. With little memory it holds fewer outcomes at
// once, and then keeps the draws of fewer steps.
template <class M>
struct CpuScratch {
  std::size_t outcomes;  // held at once: more actions than fit are simulated in blocks
  std::size_t cached_steps;

  // Of `bytes`; the least that works if there are fewer.
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
    return options.max_scenarios * kScenario + M::kActionCount * (sizeof(ActionRow) + sizeof(Gain));
  }

 private:
  static constexpr std::size_t kMostOutcomeBytes = std::size_t{20} << 20;  // more is not faster
  static constexpr std::size_t kOutcome = sizeof(CpuOutcome<M>) + CpuOutcome<M>::kHistoryBytes;
};

// Written while no worker is at work, but for the pool.
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
  // Of all workers.
  std::size_t most_scratch() const { return options.memory_bytes / 4; }

  std::size_t pool_bytes() const {
    const std::size_t apart = std::min(most_scratch(), threads * scratch.bytes(options));
    return std::max(options.memory_bytes - apart, root_bytes());
  }

  // The root can always be expanded.
  std::size_t root_bytes() const {
    const std::size_t rows = sizeof(ActionRow) + sizeof(Gain) + options.max_scenarios * sizeof(ChildRow);
    return CpuNode<M>::bytes(options.max_scenarios) + M::kActionCount * rows + kCacheLine;
  }
};

}  // namespace hypgen
