// SPDX-License-Identifier: Apache-2.0
// Second kernel of a batch: every action of every leaf over every member, and what follows from there.
#pragma once

#include "hypgen/cuda/batch.cuh"
#include "hypgen/cuda/steppers.cuh"
#include "hypgen/leaves/rollout_step.hpp"
#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen::cuda {

constexpr int kSimulateBlock = kBlock;
constexpr int kRefill = 8;  // idle lanes of a warp that are worth starting new items for

enum class Phase { kIdle, kFirstStep, kRollout };

// What a lane is at work on: an action of a leaf over one member, then the rollout from there.
template <class M>
struct Item {
  std::uint32_t number;
  std::uint32_t member;    // index into the scenarios
  std::uint32_t scenario;  // as draws are numbered
  int leaf;
  int depth;  // of the state
  int action;
  Phase phase;
  bool nan;
  typename M::State state;
  typename M::History history;
  const float* discount;
  float total;
};

// The life of one lane's items.
template <class M>
struct Lane {
  const Batch<M>& batch;
  const LeafOffsets& offsets;
  Item<M> item{};

  __device__ const typename M::Fixed& fixed() const { return batch.fixed[item.member]; }
  __device__ PhiloxDraws draws() const {
    return PhiloxDraws(batch.search.key, item.scenario, static_cast<std::uint32_t>(item.depth));
  }
  __device__ bool idle() const { return item.phase == Phase::kIdle; }

  __device__ void finish(float lower) {
    batch.lowers[item.number] = math::to_fixed(lower);
    if (item.nan || math::is_nan(lower)) atomicOr(&batch.flags[item.leaf], kNanFlag);
    item.phase = Phase::kIdle;
  }

  __device__ void start(std::uint32_t number) {
    item.leaf = offsets.leaf_of(number, batch.leaves);
    const LeafTask& task = batch.tasks[item.leaf];
    const std::uint32_t within = number - offsets.starts[item.leaf];
    const std::uint32_t i = within % task.count;
    const std::uint32_t* const block = block_of<M>(batch.members, task.base);
    item.number = number;
    item.member = block[i];
    item.scenario = batch.search.first_scenario + item.member;
    item.depth = task.depth;
    item.action = batch.legal[std::size_t(item.leaf) * batch.max_actions + within / task.count];
    item.phase = Phase::kFirstStep;
    item.nan = false;
    item.state = load_state<M>(block, task.count, i);
    if constexpr (M::kHasHistory) item.history = batch.histories[task.node];
  }

  // Whether the rollout is at its last state: then the item is finished.
  __device__ bool at_limit() {
    const SearchConstants& search = batch.search;
    if (item.depth < search.depth_limit) return false;
    finish(search.at_horizon ? item.total
                             : item.total + *item.discount * M::tail(*batch.params, fixed(), item.state));
    return true;
  }

  // The default policy's action. Below 0 there is none, and the item is finished.
  __device__ int choose(PhiloxDraws& draws) {
    const int action = M::default_policy(*batch.params, fixed(), item.state, item.history, draws);
    if (action < 0) finish(item.total);
    return action;
  }

  // Bounds the state that the item's first step led to.
  __device__ void bound(const StepResult& step, const typename M::Key& key) {
    const SearchConstants& search = batch.search;
    batch.rewards[item.number] = step.reward;
    batch.keys[item.number] = key;
    batch.terminals[item.number] = step.terminal;
    batch.uppers[item.number] = 0;
    if (step.terminal || (search.at_horizon && item.depth >= search.depth_limit)) return finish(0.0F);
    const float upper = M::upper(*batch.params, fixed(), item.state);
    item.nan |= math::is_nan(upper);
    batch.uppers[item.number] = math::to_fixed(upper);
    if (M::kHasLower && item.depth < search.depth_limit) {
      return finish(M::lower(*batch.params, fixed(), item.state, item.history));
    }
    item.discount = batch.discounts;
    item.total = 0.0F;
    item.phase = Phase::kRollout;
  }

  __device__ void after_first(const StepResult& step, PhiloxDraws& draws, const typename M::State& next) {
    if (item.action == kNoStep) return bound({}, {});
    item.nan = step.error;
    typename M::Key key{};
    if (!step.terminal) {
      key = M::observe(*batch.params, fixed(), item.state, item.action, draws, next);
      if constexpr (M::kHasHistory) {
        typename M::History after;
        M::advance_history(*batch.params, fixed(), item.state, item.action, key, next, item.history, after);
        item.history = after;
      }
    }
    item.state = next;
    ++item.depth;
    bound(step, key);
  }

  __device__ void after_rollout(const StepResult& step, PhiloxDraws& draws, int action,
                                const typename M::State& next) {
    if (!take_in<M>(step, *batch.params, fixed(), action, draws, next, *item.discount, item.state,
                    item.history, item.total, item.nan)) {
      return finish(item.total);
    }
    ++item.depth;
    ++item.discount;
  }

  // The first step of the item, and what its state is worth. Returns whether there was a step.
  __device__ bool first_step() {
    PhiloxDraws draws = this->draws();
    typename M::State next;
    StepResult step{};
    const bool stepped = item.action != kNoStep;
    if (stepped) step = M::step(*batch.params, fixed(), item.state, item.action, draws, next);
    after_first(step, draws, next);
    return stepped;
  }

  // The next step of the item's rollout, or its end. Returns whether there was a step.
  __device__ bool roll() {
    if (at_limit() || M::kHasLower) return false;  // with a bound, no rollout begins before the limit
    PhiloxDraws draws = this->draws();
    // A constant of many policies, if the compiler can see it: hence neither kept in `item`, nor merged with
    // what there is where the rollout ends.
    const int action = choose(draws);
    if (action < 0) return false;
    typename M::State next;
    const StepResult step = M::step(*batch.params, fixed(), item.state, action, draws, next);
    after_rollout(step, draws, action, next);
    return true;
  }
};

// A warp's way through a batch's items.
template <class M>
struct WarpItems {
  Lane<M>& lane;
  std::uint32_t count;  // of the batch's items
  bool exhausted = false;
  std::uint32_t taken = 0;  // steps, by this lane

  // How many idle lanes are worth starting items for: starting one costs as much as some rollout steps, and
  // all lanes of the warp would pay for the sake of one.
  __device__ int enough() const { return exhausted ? static_cast<int>(kWarp) : kRefill; }

  // Starts the next items on the lanes that `idle` names.
  __device__ void start(unsigned idle) {
    if (exhausted) return;
    const unsigned rank = threadIdx.x % kWarp;
    std::uint32_t first = 0;
    if (rank == 0) first = atomicAdd(lane.batch.next_item, __popc(idle));
    first = __shfl_sync(kAll, first, 0);
    exhausted = first + __popc(idle) >= count;
    const std::uint32_t number = first + __popc(idle & ((1U << rank) - 1));
    if (lane.idle() && number < count) lane.start(number);
  }

  __device__ void count_steps() {
    for (unsigned offset = kWarp / 2; offset > 0; offset /= 2) {
      taken += __shfl_xor_sync(kAll, taken, offset);
    }
    if (threadIdx.x % kWarp == 0) atomicAdd(lane.batch.steps, static_cast<unsigned long long>(taken));
  }

  // Each lane takes its own steps. The compiler sees a step of any action and one of the default policy's,
  // which may be simple.
  __device__ void run() {
    unsigned idle = kAll;
    while (true) {
      start(idle);
      if (lane.item.phase == Phase::kFirstStep) taken += lane.first_step();
      while (true) {
        idle = __ballot_sync(kAll, lane.idle());
        if (__popc(idle) >= enough()) break;
        if (!lane.idle()) taken += lane.roll();
      }
      if (exhausted && idle == kAll) break;
    }
    count_steps();
  }

  // Other warps help with each step, which all lanes take at the same place of the code.
  __device__ void run(const TogetherSteps<M>& steps) {
    while (true) {
      const unsigned idle = __ballot_sync(kAll, lane.idle());
      if (exhausted && idle == kAll) break;
      if (__popc(idle) >= enough()) start(idle);
      PhiloxDraws draws = lane.draws();
      if (lane.item.phase == Phase::kRollout && !lane.at_limit()) lane.item.action = lane.choose(draws);
      typename M::State next;
      const bool active = !lane.idle() && lane.item.action != kNoStep;
      const StepResult step =
          steps({*lane.batch.params, lane.fixed(), lane.item.state, lane.item.action, active}, draws, next);
      taken += active;
      if (lane.item.phase == Phase::kFirstStep) {
        lane.after_first(step, draws, next);
      } else if (lane.item.phase == Phase::kRollout) {
        lane.after_rollout(step, draws, lane.item.action, next);
      }
    }
    count_steps();
  }
};

template <class M>
__global__ void __launch_bounds__(kSimulateBlock) simulate(const __grid_constant__ Batch<M> batch) {
  __shared__ LeafOffsets offsets;
  offsets.fill(batch.leaves, [&](int leaf) { return items_of(batch, leaf); });
  Lane<M> lane{batch, offsets};
  WarpItems<M>{lane, offsets.starts[batch.leaves]}.run();
}

// The same with blocks of several warps for 32 lanes: they share the elements of each step.
template <class M>
__global__ void __launch_bounds__(kMostWarps* kWarp)
    simulate_together(const __grid_constant__ Batch<M> batch) {
  extern __shared__ __align__(16) unsigned char shared_memory[];
  __shared__ LeafOffsets offsets;
  auto& shared = *reinterpret_cast<SharedSteps<M>*>(shared_memory);
  if (threadIdx.x == 0) shared.ended = false;
  offsets.fill(batch.leaves, [&](int leaf) { return items_of(batch, leaf); });
  if (threadIdx.x >= kWarp) return serve(shared, *batch.params, batch.search.key);
  Lane<M> lane{batch, offsets};
  const TogetherSteps<M> steps{shared, batch.search.key, lane.item.scenario, lane.item.depth};
  WarpItems<M>{lane, offsets.starts[batch.leaves]}.run(steps);
  steps.end();
}

}  // namespace hypgen::cuda
