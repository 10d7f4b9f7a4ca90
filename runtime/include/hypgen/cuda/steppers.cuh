// SPDX-License-Identifier: Apache-2.0
// Steps that the warps of a block take together.
#pragma once

#include "hypgen/cuda/batch.cuh"
#include "hypgen/model/model.hpp"
#include "hypgen/model/part.hpp"

namespace hypgen::cuda {

// A lane's step in the making.
template <class M>
struct StepInput {
  const typename M::Params& params;
  const typename M::Fixed& fixed;
  const typename M::State& state;
  int action;
  bool active;  // false: the lane has nothing to step
};

// A barrier of the block that warps may reach at different places of the code, and lanes by different ways.
__device__ inline void meet() {
  __syncwarp();
  asm volatile("barrier.sync 1, %0;" ::"r"(blockDim.x) : "memory");
}

// A struct of words with an odd number of them, so that lanes that read the same word of their structs find
// them in different banks.
template <class Words>
struct Padded {
  static constexpr std::size_t kWords = sizeof(Words) / sizeof(std::uint32_t);
  Words value;
  std::uint32_t padding[kWords % 2 == 0 ? 1 : 2];
};

// The shared memory of a block whose warps take steps of the same 32 lanes together.
template <class M>
struct SharedSteps {
  Padded<typename M::State> states[kWarp];
  Padded<typename M::State> nexts[kWarp];
  const typename M::Fixed* fixed[kWarp];  // in device memory; for warps that `serve`
  std::int64_t sums[kMostWarps][kWarp];
  int actions[kWarp];
  std::uint32_t scenarios[kWarp];  // as draws are numbered
  std::uint32_t times[kWarp];
  std::uint32_t errors[kMostWarps];
  bool ended;  // there will be no more steps

  // For one warp: sets its lane's step.
  __device__ void put(const StepInput<M>& input, std::uint32_t scenario, std::uint32_t time) {
    const unsigned lane = threadIdx.x % kWarp;
    actions[lane] = input.active ? input.action : kNoStep;
    if (!input.active) return;
    states[lane].value = input.state;
    nexts[lane].value = input.state;
    scenarios[lane] = scenario;
    times[lane] = time;
  }

  // For all warps, after a barrier of the caller: does this warp's part of the steps.
  __device__ void work(const typename M::Params& params, const typename M::Fixed& own_fixed, StreamKey key) {
    const unsigned lane = threadIdx.x % kWarp;
    const Part part{static_cast<int>(threadIdx.x / kWarp), static_cast<int>(blockDim.x / kWarp)};
    const int action = actions[lane];
    const bool active = action != kNoStep;
    PhiloxDraws draws(key, active ? scenarios[lane] : 0, active ? times[lane] : 0);
    for (int stage = 0; stage < M::kStages; ++stage) {
      if (active) {
        M::step_stage(stage, params, own_fixed, states[lane].value, action, draws, nexts[lane].value, part);
      }
      meet();
    }
    std::int64_t sum = 0;
    bool error = false;
    if (active) {
      M::step_rewards(params, own_fixed, states[lane].value, action, draws, nexts[lane].value, part, sum,
                      error);
    }
    sums[part.rank][lane] = sum;
    __syncwarp();
    const unsigned votes = __ballot_sync(kAll, error);
    if (lane == 0) errors[part.rank] = votes;
    meet();
  }

  // After `work`: what this lane's step came to.
  __device__ StepResult result(const StepInput<M>& input, PhiloxDraws& draws, typename M::State& next) const {
    const unsigned lane = threadIdx.x % kWarp;
    if (!input.active) return {};
    std::int64_t sum = 0;
    std::uint32_t error = 0;
    for (unsigned warp = 0; warp < blockDim.x / kWarp; ++warp) {
      sum += sums[warp][lane];
      error |= errors[warp];
    }
    next = nexts[lane].value;
    return M::step_end(input.params, input.fixed, input.state, input.action, draws, next, sum,
                       (error >> lane & 1) != 0);
  }
};

// The first warp's side of a block that steps together; the others `serve` it.
template <class M>
struct TogetherSteps {
  SharedSteps<M>& shared;
  StreamKey key;
  const std::uint32_t& scenario;  // of the lane's item at present, as draws are numbered
  const int& time;

  __device__ StepResult operator()(const StepInput<M>& input, PhiloxDraws& draws,
                                   typename M::State& next) const {
    shared.put(input, scenario, static_cast<std::uint32_t>(time));
    shared.fixed[threadIdx.x] = &input.fixed;
    meet();
    shared.work(input.params, input.fixed, key);
    return shared.result(input, draws, next);
  }

  __device__ void end() const {
    if (threadIdx.x == 0) shared.ended = true;
    meet();
  }
};

// What the other warps do until the first one ends.
template <class M>
__device__ void serve(SharedSteps<M>& shared, const typename M::Params& params, StreamKey key) {
  while (true) {
    meet();
    if (shared.ended) return;
    shared.work(params, *shared.fixed[threadIdx.x % kWarp], key);
  }
}

}  // namespace hypgen::cuda
