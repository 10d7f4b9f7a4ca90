// SPDX-License-Identifier: Apache-2.0
// A model as checks see it: all that planning asks of one, and what checks alone ask.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "hypgen/model/descriptor.hpp"
#include "hypgen/verify/bound_sums.hpp"
#include "hypgen/verify/digest.hpp"

namespace hypgen {

struct BoundsWalk;
struct ScheduleFault;
struct TraceOptions;

// A model with its params.
class VerifiableInstance : public ModelInstance {
 public:
  // Writes the trace that differential tests compare; false and `error` if the file cannot be written.
  virtual bool write_trace(const TraceOptions& options, std::string& error) const = 0;
  // Writes a digest for each lane of the range, of plain steps or, with several warps, of steps in parts;
  // gives the first fault of the schedule. Threads may call it at the same time.
  virtual ScheduleFault digests(const DigestRange& range, int warps, std::uint64_t* out) const = 0;
  // Compares the bounds at beliefs along episodes with what the default policy earns. Threads may call it at
  // the same time.
  virtual BoundsFound check_bounds(const BoundsWalk& walk) const = 0;
};

// `descriptor.create` is not used.
struct VerifiableModel {
  ModelDescriptor descriptor;
  int most_warps = 1;  // that find something to do in a step
  std::function<std::unique_ptr<VerifiableInstance>(const ParamValues&, std::string& error)> create;
  // walk_on_device of the model (device_walk.hpp); empty without CUDA.
  std::function<bool(const void* params, const DigestRange& range, int warps, int device, std::uint64_t* out,
                     std::string& error)>
      walk_on_device;
};

}  // namespace hypgen
