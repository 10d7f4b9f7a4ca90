// SPDX-License-Identifier: Apache-2.0
// The kernels of a batch that step: every action of every leaf over every member, and then the default policy
// from there, for the actions that are rolled out.
#pragma once

#include "hypgen/cuda/batch.cuh"
#include "hypgen/cuda/steppers.cuh"
#include "hypgen/leaves/rollout_step.hpp"
#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen::cuda {

constexpr int kSimulateBlock = kBlock;
constexpr int kRefill = 8;  // idle lanes of a warp that are worth starting new items for

constexpr std::uint32_t kOwnState = UINT32_MAX;

enum class Phase { kIdle, kFirstStep, kRollout };

// What a lane is at work on: an action of a leaf over one member, then the rollout from there.
template <class M>
struct Item {
  std::uint32_t number;
  std::uint32_t member;    // index into the scenarios
  std::uint32_t scenario;  // as draws are numbered
  std::uint32_t group;     // of a weighted search, where it sees another state than its own; else kOwnState
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

// The life of one lane's items in a pass.
template <class M, Pass pass>
struct Lane {
  const Batch<M>& batch;
  const LeafOffsets& offsets;  // of the pass's items
  const LeafOffsets& results;  // of where results lie: the first pass's items
  Item<M> item{};

  __device__ const typename M::Fixed& fixed() const { return batch.fixed[item.member]; }
  __device__ PhiloxDraws draws() const {
    return PhiloxDraws(batch.search.key, item.scenario, static_cast<std::uint32_t>(item.depth));
  }
  __device__ bool idle() const { return item.phase == Phase::kIdle; }

  __device__ std::int64_t* lower_of_item() const {
    if (pass != Pass::kWeighted || item.group == kOwnState) return &batch.lowers[item.number];
    return &batch.group_bounds[std::size_t{item.number} * WeighedItems<M>::kShared + item.group].lower;
  }

  __device__ void finish(float lower) {
    *lower_of_item() = math::to_fixed<kRewardBits<M>>(lower);
    if (item.nan || math::is_nan(lower)) atomicOr(&batch.flags[item.leaf], kNanFlag);
    item.phase = Phase::kIdle;
  }

  __device__ void start(std::uint32_t number) {
    if constexpr (pass == Pass::kWeighted) return start_weighted(number);
    item.leaf = offsets.leaf_of(number, batch.leaves);
    const LeafTask& task = batch.tasks[item.leaf];
    const std::uint32_t within = number - offsets.starts[item.leaf];
    const std::uint32_t i = within % task.count;
    const std::size_t list = std::size_t(item.leaf) * batch.max_actions;
    std::uint32_t place = within / task.count;
    if (pass == Pass::kRollouts) place = batch.rolled[list + place];
    const std::uint32_t* const block = block_of<M>(batch.members, task.base);
    item.number = results.starts[item.leaf] + place * task.count + i;
    item.member = block[i];
    item.scenario = batch.search.first_scenario + (batch.search.weighted ? i : item.member);
    item.depth = task.depth;
    item.action = batch.legal[list + place];
    item.phase = Phase::kFirstStep;
    item.nan = false;
    item.state = load_state<M>(block, task.count, i);
    if constexpr (M::kHasHistory) item.history = batch.histories[task.node];
  }

  // An item of a weighted search after its first step, which `weigh` has taken.
  __device__ void start_weighted(std::uint32_t number) {
    const std::uint32_t own = offsets.starts[batch.leaves];
    item.group = kOwnState;
    std::uint32_t place, i;
    if (number < own) {
      item.leaf = offsets.leaf_of(number, batch.leaves);
      const std::uint32_t within = number - offsets.starts[item.leaf], count = batch.tasks[item.leaf].count;
      place = batch.rolled[std::size_t(item.leaf) * batch.max_actions + within / count];
      i = within % count;
      item.number = results.starts[item.leaf] + place * count + i;
    } else {
      const Extra extra = batch.extras[number - own];
      item.leaf = results.leaf_of(extra.item, batch.leaves);
      const std::uint32_t within = extra.item - results.starts[item.leaf];
      place = within / batch.tasks[item.leaf].count;
      i = within % batch.tasks[item.leaf].count;
      item.number = extra.item;
      item.group = extra.group;
    }
    const LeafTask& task = batch.tasks[item.leaf];
    const std::uint32_t* const block = block_of<M>(batch.members, task.base);
    item.action = batch.legal[std::size_t(item.leaf) * batch.max_actions + place];
    item.member = block[i];
    item.scenario = batch.search.first_scenario + i;
    item.depth = task.depth + 1;
    item.nan = false;
    const bool is_at_end = item.depth >= batch.search.depth_limit;
    if (place >= batch.legal_count[item.leaf] || batch.terminals[item.number] != 0 ||
        (item.group == kOwnState && is_at_end)) {
      return;  // the first pass knows all
    }
    const ScenarioShares<M>& shares = batch.action_shares[std::size_t(item.leaf) * batch.max_actions + place];
    std::uint32_t seen_by = i;
    if (item.group == kOwnState) {
      item.state = batch.items.nexts[item.number];
      if constexpr (M::kHasHistory) seen_by = batch.seen_by[item.number];
    } else {
      item.state = *shares.next(item.group, i);
      seen_by = shares.first(item.group);
      const float upper =
          batch.search.at_horizon && is_at_end ? 0.0F : M::upper(*batch.params, fixed(), item.state);
      item.nan = math::is_nan(upper);
      batch.group_bounds[std::size_t{item.number} * WeighedItems<M>::kShared + item.group].upper =
          math::to_fixed<kRewardBits<M>>(upper);
    }
    if constexpr (M::kHasHistory) {
      const std::uint32_t other = item.number - i + seen_by;
      M::advance_history(*batch.params, batch.fixed[block[seen_by]],
                         load_state<M>(block, task.count, seen_by), item.action, batch.keys[other],
                         batch.items.nexts[other], batch.histories[task.node], item.history);
    }
    if (is_at_end) {
      return finish(batch.search.at_horizon ? 0.0F : M::tail(*batch.params, fixed(), item.state));
    }
    if constexpr (M::kHasLower) return finish(M::lower(*batch.params, fixed(), item.state, item.history));
    item.discount = batch.discounts;
    item.total = 0.0F;
    item.phase = Phase::kRollout;
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

  // What a state is worth at the least that is not rolled out.
  __device__ float floor() const {
    const SearchConstants& search = batch.search;
    return search.at_horizon ? batch.floors[search.depth_limit - item.depth]
                             : M::tail(*batch.params, fixed(), item.state);
  }

  // The first pass: bounds the state that the item's first step led to.
  __device__ void bound(const StepResult& step, const typename M::Key& key) {
    const SearchConstants& search = batch.search;
    batch.rewards[item.number] = step.reward;
    batch.keys[item.number] = key;
    batch.terminals[item.number] = step.terminal;
    batch.uppers[item.number] = 0;
    if (step.terminal || (search.at_horizon && item.depth >= search.depth_limit)) return finish(0.0F);
    const float upper = M::upper(*batch.params, fixed(), item.state);
    item.nan |= math::is_nan(upper);
    const std::int64_t most = math::to_fixed<kRewardBits<M>>(upper);
    batch.uppers[item.number] = most;
    if (M::kHasLower && item.depth < search.depth_limit) {
      return finish(M::lower(*batch.params, fixed(), item.state, item.history));
    }
    if (item.depth >= search.depth_limit) return finish(M::tail(*batch.params, fixed(), item.state));
    if (batch.tasks[item.leaf].rolled == kRollsAll) return finish(0.0F);  // the second pass knows better
    const float least = floor();
    finish(least);
    batch.lowers[item.number] = min(most, math::to_fixed<kRewardBits<M>>(least));
  }

  // The second pass: what the default policy earns from there.
  __device__ void begin_rollout(const StepResult& step) {
    if (step.terminal || item.depth >= batch.search.depth_limit) {
      item.phase = Phase::kIdle;  // the first pass knows all
      return;
    }
    item.discount = batch.discounts;
    item.total = 0.0F;
    item.phase = Phase::kRollout;
  }

  __device__ void after_first(const StepResult& step, PhiloxDraws& draws, const typename M::State& next) {
    constexpr bool kNeedsHistory = M::kHasHistory && (pass == Pass::kRollouts || M::kHasLower);
    constexpr bool kNeedsKey = kNeedsHistory || pass == Pass::kFirstSteps;
    StepResult found{};
    typename M::Key key{};
    if (item.action != kNoStep) {
      found = step;
      item.nan = is_broken<M>(step);
      if (kNeedsKey && !step.terminal) {
        key = M::observe(*batch.params, fixed(), item.state, item.action, draws, next);
        if constexpr (kNeedsHistory) {
          typename M::History after;
          M::advance_history(*batch.params, fixed(), item.state, item.action, key, next, item.history, after);
          item.history = after;
        }
      }
      item.state = next;
      ++item.depth;
    }
    if constexpr (pass == Pass::kFirstSteps) {
      bound(found, key);
    } else {
      begin_rollout(found);
    }
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

// A warp's way through a pass's items.
template <class M, Pass pass>
struct WarpItems {
  Lane<M, pass>& lane;
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
    constexpr int kCounter = pass == Pass::kFirstSteps ? 0 : 1;
    if (rank == 0) first = atomicAdd(lane.batch.next_item + kCounter, __popc(idle));
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

// Where the items of a pass begin, by leaf, and where their results lie.
template <Pass pass>
struct PassOffsets {
  LeafOffsets results;
  LeafOffsets rolled;

  template <class M>
  __device__ void fill(const Batch<M>& batch) {
    results.fill(batch.leaves, [&](int leaf) { return items_of(batch, leaf); });
    rolled.fill(batch.leaves, [&](int leaf) { return rolled_items_of(batch, leaf); });
  }
  __device__ const LeafOffsets& items() const { return rolled; }
};

template <>
struct PassOffsets<Pass::kFirstSteps> {
  LeafOffsets results;

  template <class M>
  __device__ void fill(const Batch<M>& batch) {
    results.fill(batch.leaves, [&](int leaf) { return items_of(batch, leaf); });
  }
  __device__ const LeafOffsets& items() const { return results; }
};

// How many items a pass has, once its offsets are there.
template <Pass pass, class M>
__device__ std::uint32_t item_count(const Batch<M>& batch, const PassOffsets<pass>& offsets) {
  const std::uint32_t own = offsets.items().starts[batch.leaves];
  return pass == Pass::kWeighted ? own + *batch.extra_count : own;
}

template <class M, Pass pass>
__global__ void __launch_bounds__(kSimulateBlock) simulate(const __grid_constant__ Batch<M> batch) {
  __shared__ PassOffsets<pass> offsets;
  offsets.fill(batch);
  Lane<M, pass> lane{batch, offsets.items(), offsets.results};
  WarpItems<M, pass>{lane, item_count(batch, offsets)}.run();
}

// The same with blocks of several warps for 32 lanes: they share the elements of each step.
template <class M, Pass pass>
__global__ void __launch_bounds__(kMostWarps* kWarp)
    simulate_together(const __grid_constant__ Batch<M> batch) {
  extern __shared__ __align__(16) unsigned char shared_memory[];
  __shared__ PassOffsets<pass> offsets;
  auto& shared = *reinterpret_cast<SharedSteps<M>*>(shared_memory);
  if (threadIdx.x == 0) shared.ended = false;
  offsets.fill(batch);
  if (threadIdx.x >= kWarp) return serve(shared, *batch.params, batch.search.key);
  Lane<M, pass> lane{batch, offsets.items(), offsets.results};
  const TogetherSteps<M> steps{shared, batch.search.key, lane.item.scenario, lane.item.depth};
  WarpItems<M, pass>{lane, item_count(batch, offsets)}.run(steps);
  steps.end();
}

}  // namespace hypgen::cuda
