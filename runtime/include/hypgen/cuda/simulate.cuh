// Second kernel of a batch: every action of every leaf over every member, and what follows from there.
#pragma once

#include "hypgen/cuda/batch.cuh"
#include "hypgen/math.hpp"
#include "hypgen/model.hpp"
#include "hypgen/rollout_step.hpp"

namespace hypgen::cuda {

constexpr int kSimulateBlock = kBlock;
constexpr unsigned kRefill = 8;  // idle lanes of a warp that are worth starting new items for

// A lane's item, and its rollout.
template <class M>
struct Item {
  std::uint32_t number;
  std::uint32_t scenario;
  int leaf;
  int depth;  // of the state
  typename M::State state;
  typename M::History history;
  const float* discount;
  float total;
  bool nan;
};

template <class M>
__device__ inline void finish(const Batch<M>& batch, const Item<M>& item, float lower) {
  batch.lowers[item.number] = math::to_fixed(lower);
  if (item.nan || math::is_nan(lower)) atomicOr(&batch.flags[item.leaf], kNanFlag);
}

// Simulates the item's step and bounds the state that it leads to. Returns whether a rollout has to go on
// from there.
template <class M>
__device__ bool start(const Batch<M>& batch, const LeafOffsets& offsets, std::uint32_t number,
                      Item<M>& item) {
  const SearchConstants& search = batch.search;
  item.leaf = offsets.leaf_of(number, batch.leaves);
  const LeafTask& task = batch.tasks[item.leaf];
  const std::uint32_t within = number - offsets.starts[item.leaf];
  const std::uint32_t i = within % task.count;
  const std::int32_t action = batch.legal[std::size_t(item.leaf) * batch.max_actions + within / task.count];
  const std::uint32_t* const block = block_of<M>(batch.members, task.base);
  item.number = number;
  item.scenario = block[i];
  item.depth = task.depth;
  item.nan = false;
  item.state = load_state<M>(block, task.count, i);
  if constexpr (M::kHasHistory) item.history = batch.histories[task.node];
  const typename M::Fixed& fixed = batch.fixed[item.scenario];
  StepResult step{};
  typename M::Key key{};
  if (action != kNoStep) {
    PhiloxDraws draws(search.key, search.first_scenario + item.scenario,
                      static_cast<std::uint32_t>(task.depth));
    typename M::State next;
    step = M::step(*batch.params, fixed, item.state, action, draws, next);
    item.nan = step.error;
    if (!step.terminal) {
      key = M::observe(*batch.params, fixed, item.state, action, draws, next);
      if constexpr (M::kHasHistory) {
        typename M::History after;
        M::advance_history(*batch.params, fixed, item.state, action, key, next, item.history, after);
        item.history = after;
      }
    }
    item.state = next;
    ++item.depth;
  }
  batch.rewards[number] = step.reward;
  batch.keys[number] = key;
  batch.terminals[number] = step.terminal;
  if (step.terminal || (search.at_horizon && item.depth >= search.depth_limit)) {
    batch.uppers[number] = 0;
    finish(batch, item, 0.0F);
    return false;
  }
  const float upper = M::upper(*batch.params, fixed, item.state);
  item.nan |= math::is_nan(upper);
  batch.uppers[number] = math::to_fixed(upper);
  if (M::kHasLower && item.depth < search.depth_limit) {
    finish(batch, item, M::lower(*batch.params, fixed, item.state, item.history));
    return false;
  }
  item.discount = batch.discounts;
  item.total = 0.0F;
  return true;
}

// Takes one step of the item's rollout. Returns whether it goes on.
template <class M>
__device__ bool roll(const Batch<M>& batch, Item<M>& item) {
  const SearchConstants& search = batch.search;
  const typename M::Fixed& fixed = batch.fixed[item.scenario];
  if (item.depth >= search.depth_limit) {
    finish(batch, item,
           search.at_horizon ? item.total
                             : item.total + *item.discount * M::tail(*batch.params, fixed, item.state));
    return false;
  }
  PhiloxDraws draws(search.key, search.first_scenario + item.scenario,
                    static_cast<std::uint32_t>(item.depth));
  if (!roll_step<M>(*batch.params, fixed, draws, *item.discount, item.state, item.history, item.total,
                    item.nan)) {
    finish(batch, item, item.total);
    return false;
  }
  ++item.depth;
  ++item.discount;
  return true;
}

// Lanes that finish wait until a few of their warp have, then take the next items together: starting costs as
// much as some rollout steps, and so would be paid by all lanes for the sake of one.
template <class M>
__global__ void __launch_bounds__(kSimulateBlock) simulate(const __grid_constant__ Batch<M> batch) {
  __shared__ LeafOffsets offsets;
  offsets.fill(batch.leaves, [&](int leaf) { return items_of(batch, leaf); });
  const std::uint32_t count = offsets.starts[batch.leaves];
  const unsigned lane = threadIdx.x % kWarp;
  Item<M> item{};
  bool rolling = false;
  bool exhausted = false;
  std::uint32_t steps = 0;
  while (true) {
    const unsigned idle = __ballot_sync(kAll, !rolling);
    if (!exhausted && (idle == kAll || __popc(idle) >= kRefill)) {
      std::uint32_t first = 0;
      if (lane == 0) first = atomicAdd(batch.next_item, __popc(idle));
      first = __shfl_sync(kAll, first, 0);
      exhausted = first + __popc(idle) >= count;
      const std::uint32_t number = first + __popc(idle & ((1U << lane) - 1));
      if (!rolling && number < count) {
        rolling = start(batch, offsets, number, item);
        ++steps;
      }
    } else if (idle == kAll) {
      break;
    }
    if (rolling) {
      rolling = roll(batch, item);
      ++steps;
    }
  }
  for (unsigned offset = kWarp / 2; offset > 0; offset /= 2) steps += __shfl_xor_sync(kAll, steps, offset);
  if (lane == 0) atomicAdd(batch.steps, static_cast<unsigned long long>(steps));
}

}  // namespace hypgen::cuda
