// SPDX-License-Identifier: Apache-2.0
// Digests of random walks on a device (see hypgen/verify/digest.hpp): a unit of the program that checks.
#pragma once

#include "hypgen/cuda/memory.cuh"
#include "hypgen/cuda/steppers.cuh"
#include "hypgen/verify/device_walk.hpp"
#include "hypgen/verify/digest.hpp"

namespace hypgen::cuda {

constexpr int kDigestBlock = 128;

template <class M>
__global__ void __launch_bounds__(kDigestBlock)
    walk(const typename M::Params* params, DigestRange range, std::uint64_t* digests) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= range.lanes) return;
  DigestLane<M> lane(*params, range.key, range.first_lane + i);
  lane.start();
  for (std::uint32_t t = 0; t < range.steps; ++t) lane.step(t);
  digests[i] = lane.value();
}

// A block for 32 lanes: every warp walks all of them, and they take the steps together.
template <class M>
__global__ void __launch_bounds__(kMostWarps* kWarp)
    walk_together(const typename M::Params* params, DigestRange range, std::uint64_t* digests) {
  extern __shared__ __align__(16) unsigned char shared_memory[];
  auto& shared = *reinterpret_cast<SharedSteps<M>*>(shared_memory);
  const std::uint32_t i = blockIdx.x * kWarp + threadIdx.x % kWarp;
  const std::uint32_t number = range.first_lane + i;
  std::uint32_t time = 0;
  const auto stepper = [&](const typename M::Params& all, const typename M::Fixed& fixed,
                           const typename M::State& state, int action, PhiloxDraws& draws,
                           typename M::State& next, bool active) {
    const StepInput<M> input{all, fixed, state, action, active};
    if (threadIdx.x < kWarp) shared.put(input, number, time);
    ++time;
    meet();
    shared.work(all, fixed, range.key);
    const StepResult result = shared.result(input, draws, next);
    meet();
    return result;
  };
  const std::uint64_t value = digest_lane<M>(*params, range.key, number, range.steps, stepper);
  if (threadIdx.x < kWarp && i < range.lanes) digests[i] = value;
}

// Starts shared walks, if several warps are asked for and shared memory can hold the states: those that are
// too large are stepped by single lanes, as in the evaluator. False and `error` on a failure.
template <class M>
bool start_together(const typename M::Params* params, const DigestRange& range, int warps,
                    std::uint64_t* digests, bool& started, std::string& error) {
  constexpr auto kBytes = static_cast<int>(sizeof(SharedSteps<M>));
  int device = 0, shared = 0;
  if (!worked(cudaGetDevice(&device), "GPU", error) ||
      !worked(cudaDeviceGetAttribute(&shared, cudaDevAttrMaxSharedMemoryPerBlockOptin, device), "GPU",
              error)) {
    return false;
  }
  if (warps <= 1 || kBytes > shared) return true;
  if (!worked(cudaFuncSetAttribute(walk_together<M>, cudaFuncAttributeMaxDynamicSharedMemorySize, kBytes),
              "shared memory", error)) {
    return false;
  }
  walk_together<M><<<(range.lanes + kWarp - 1) / kWarp, static_cast<unsigned>(warps) * kWarp, kBytes>>>(
      params, range, digests);
  started = true;
  return true;
}

// Runs either.
template <class M>
bool walk_on_device(const void* params, const DigestRange& range, int warps, int device, std::uint64_t* out,
                    std::string& error) {
  if (!worked(cudaSetDevice(device), "GPU", error)) return false;
  DeviceArray<typename M::Params> device_params;
  DeviceArray<std::uint64_t> digests;
  if (!device_params.allocate(1, error) || !digests.allocate(range.lanes, error) ||
      !worked(cudaMemcpy(device_params.get(), params, sizeof(typename M::Params), cudaMemcpyHostToDevice),
              "GPU", error)) {
    return false;
  }
  bool started = false;
  if constexpr (M::kMaxWarps > 1) {
    if (!start_together<M>(device_params.get(), range, warps, digests.get(), started, error)) return false;
  }
  if (!started) {
    walk<M><<<(range.lanes + kDigestBlock - 1) / kDigestBlock, kDigestBlock>>>(device_params.get(), range,
                                                                               digests.get());
  }
  return worked(cudaGetLastError(), "kernel launch", error) &&
         worked(cudaDeviceSynchronize(), "GPU", error) &&
         worked(cudaMemcpy(out, digests.get(), range.lanes * sizeof(std::uint64_t), cudaMemcpyDeviceToHost),
                "GPU", error);
}

}  // namespace hypgen::cuda
