// SPDX-License-Identifier: Apache-2.0
// The interface of a model's code for GPUs. This header needs no CUDA header.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hypgen/random/philox.hpp"

namespace hypgen {

class LeafEvaluator;
struct EvaluatorOptions;

struct DeviceInfo {
  int index = 0;
  std::string name;
  int major = 0;  // compute capability
  int minor = 0;
  int multiprocessors = 0;
  std::size_t total_bytes = 0;
};

// What digests are taken of: lanes 0 .. lanes - 1, each `steps` steps, drawn from stream `key`.
struct DigestRange {
  StreamKey key{};
  std::uint32_t first_lane = 0;
  std::uint32_t lanes = 0;
  std::uint32_t steps = 0;
};

// One model's functions on GPUs. Every call that fails gives null or false and says why in `error`; none
// throws.
class DeviceSupport {
 public:
  virtual ~DeviceSupport() = default;

  // The GPUs that this solver has code for; empty and `error` if there is none.
  virtual std::vector<DeviceInfo> devices(std::string& error) const = 0;

  // `params` points to the model's Params, which may go away after the call.
  virtual std::unique_ptr<LeafEvaluator> make_evaluator(const void* params, const EvaluatorOptions& options,
                                                        int device, std::string& error) const = 0;

  // Digests of lanes on a device, by `warps` warps a step (1: the plain step).
  virtual bool digests(const void* params, const DigestRange& range, int warps, int device,
                       std::uint64_t* out, std::string& error) const = 0;
};

}  // namespace hypgen
