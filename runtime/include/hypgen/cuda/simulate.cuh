// Second kernel of a batch: every action of every leaf over every member, and what follows from there.
#pragma once

#include "hypgen/cuda/batch.cuh"
#include "hypgen/cuda/steppers.cuh"
#include "hypgen/math.hpp"
#include "hypgen/model.hpp"
#include "hypgen/rollout_step.hpp"

namespace hypgen::cuda {

constexpr int kSimulateBlock = kBlock;
constexpr unsigned kRefill = 8;  // idle lanes of a warp that are worth starting new items for

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

  // Chooses the rollout's next action, or ends the rollout.
  __device__ void choose(PhiloxDraws& draws) {
    const SearchConstants& search = batch.search;
    if (item.depth >= search.depth_limit) {
      finish(search.at_horizon ? item.total
                               : item.total + *item.discount * M::tail(*batch.params, fixed(), item.state));
      return;
    }
    item.action = M::default_policy(*batch.params, fixed(), item.state, item.history, draws);
    if (item.action < 0) finish(item.total);
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

  __device__ void after_rollout(const StepResult& step, PhiloxDraws& draws, const typename M::State& next) {
    if (!take_in<M>(step, *batch.params, fixed(), item.action, draws, next, *item.discount, item.state,
                    item.history, item.total, item.nan)) {
      return finish(item.total);
    }
    ++item.depth;
    ++item.discount;
  }
};

// Runs a warp's lanes until no item is left. Lanes that finish wait until a few of the warp have, then take
// the next items together: starting costs as much as some rollout steps, and so would be paid by all lanes
// for the sake of one. `steps` takes the step of all lanes of the warp at once.
template <class M, class Steps>
__device__ void run_items(Lane<M>& lane, std::uint32_t count, const Steps& steps) {
  const Batch<M>& batch = lane.batch;
  const unsigned rank = threadIdx.x % kWarp;
  bool exhausted = false;
  std::uint32_t taken = 0;
  while (true) {
    const unsigned idle = __ballot_sync(kAll, lane.idle());
    if (!exhausted && (idle == kAll || __popc(idle) >= kRefill)) {
      std::uint32_t first = 0;
      if (rank == 0) first = atomicAdd(batch.next_item, __popc(idle));
      first = __shfl_sync(kAll, first, 0);
      exhausted = first + __popc(idle) >= count;
      const std::uint32_t number = first + __popc(idle & ((1U << rank) - 1));
      if (lane.idle() && number < count) lane.start(number);
    } else if (idle == kAll) {
      break;
    }
    PhiloxDraws draws = lane.draws();
    if (lane.item.phase == Phase::kRollout) lane.choose(draws);
    typename M::State next;
    const bool active = !lane.idle() && lane.item.action != kNoStep;
    const StepResult step = steps(
        StepInput<M>{*batch.params, lane.fixed(), lane.item.state, lane.item.action, active}, draws, next);
    taken += active;
    if (lane.item.phase == Phase::kFirstStep) {
      lane.after_first(step, draws, next);
    } else if (lane.item.phase == Phase::kRollout) {
      lane.after_rollout(step, draws, next);
    }
  }
  for (unsigned offset = kWarp / 2; offset > 0; offset /= 2) taken += __shfl_xor_sync(kAll, taken, offset);
  if (rank == 0) atomicAdd(batch.steps, static_cast<unsigned long long>(taken));
}

template <class M>
__global__ void __launch_bounds__(kSimulateBlock) simulate(const __grid_constant__ Batch<M> batch) {
  __shared__ LeafOffsets offsets;
  offsets.fill(batch.leaves, [&](int leaf) { return items_of(batch, leaf); });
  Lane<M> lane{batch, offsets};
  run_items(lane, offsets.starts[batch.leaves], OwnSteps{});
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
  run_items(lane, offsets.starts[batch.leaves], steps);
  steps.end();
}

}  // namespace hypgen::cuda
