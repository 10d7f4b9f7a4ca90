// SPDX-License-Identifier: Apache-2.0
// The interface of a model's code for GPUs. This header needs no CUDA header.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hypgen/model/key.hpp"

namespace hypgen {

class LeafEvaluator;
class Worlds;
struct EvaluatorOptions;

struct DeviceInfo {
  int index = 0;
  std::string name;
  int major = 0;  // compute capability
  int minor = 0;
  int multiprocessors = 0;
  std::size_t total_bytes = 0;
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

  // The same of `params`. `digits` are those of an observation's key.
  virtual std::unique_ptr<Worlds> make_worlds(const void* params, std::uint64_t seed, std::size_t count,
                                              const std::vector<KeyDigit>& digits, int device,
                                              std::string& error) const = 0;
};

}  // namespace hypgen
