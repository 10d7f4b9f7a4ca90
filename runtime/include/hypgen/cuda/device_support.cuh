// SPDX-License-Identifier: Apache-2.0
// One model on GPUs: what a generated device unit instantiates.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hypgen/cuda/evaluator.cuh"
#include "hypgen/cuda/worlds.cuh"
#include "hypgen/leaves/device.hpp"
#include "hypgen/model/model_contract.hpp"

namespace hypgen::cuda {

// GPUs whose architecture this program has code for.
template <class M>
std::vector<DeviceInfo> usable_devices(std::string& error) {
  int count = 0;
  std::vector<DeviceInfo> found;
  const cudaError_t counted = cudaGetDeviceCount(&count);
  if (counted == cudaErrorInsufficientDriver) {  // also where there is none at all
    error = "no GPU: no NVIDIA driver, or one that is older than CUDA " +
            std::to_string(CUDART_VERSION / 1000) + "." + std::to_string(CUDART_VERSION % 1000 / 10) +
            " needs";
    return found;
  }
  if (!worked(counted, "no GPU", error)) return found;
  if (count == 0) error = "no GPU";
  for (int index = 0; index < count; ++index) {
    cudaDeviceProp properties;
    cudaFuncAttributes attributes;
    if (!worked(cudaGetDeviceProperties(&properties, index), "GPU", error) ||
        !worked(cudaSetDevice(index), "GPU", error) ||
        !worked(cudaFuncGetAttributes(&attributes, gather<M>), properties.name, error)) {
      continue;
    }
    DeviceInfo& info = found.emplace_back();
    info.index = index;
    info.name = properties.name;
    info.major = properties.major;
    info.minor = properties.minor;
    info.multiprocessors = properties.multiProcessorCount;
    info.total_bytes = properties.totalGlobalMem;
  }
  if (!found.empty()) error.clear();
  return found;
}

template <class M>
class ModelDeviceSupport final : public DeviceSupport {
  static_assert(DeviceModelContract<M>::kHolds);

 public:
  std::vector<DeviceInfo> devices(std::string& error) const override { return usable_devices<M>(error); }

  std::unique_ptr<LeafEvaluator> make_evaluator(const void* params, const EvaluatorOptions& options,
                                                int device, std::string& error) const override {
    return CudaEvaluator<M>::make(*static_cast<const typename M::Params*>(params), options, device, error);
  }

  std::unique_ptr<Worlds> make_worlds(const void* params, std::uint64_t seed, std::size_t count,
                                      const std::vector<KeyDigit>& digits, int device,
                                      std::string& error) const override {
    return CudaWorlds<M>::make(*static_cast<const typename M::Params*>(params), seed, count, digits, device,
                               error);
  }
};

}  // namespace hypgen::cuda
