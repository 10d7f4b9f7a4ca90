// SPDX-License-Identifier: Apache-2.0
// Digests of walks on a GPU, as host code calls for them. This header needs no CUDA header.
#pragma once

#include <cstdint>
#include <string>

#include "hypgen/verify/digest.hpp"

namespace hypgen::cuda {

// Writes a digest for each lane of a range on a device, by `warps` warps a step (1: the plain step). False and
// `error` on a failure. `params` points to the model's Params, which
// may go away after the call.
//
// The unit that is compiled for GPUs instantiates it: hypgen/cuda/digests.cuh.
template <class M>
bool walk_on_device(const void* params, const DigestRange& range, int warps, int device, std::uint64_t* out,
                    std::string& error);

}  // namespace hypgen::cuda
