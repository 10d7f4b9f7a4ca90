// SPDX-License-Identifier: Apache-2.0
// Digests of many random walks at once, and where two ways of walking part.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "hypgen/verify/digest.hpp"
#include "hypgen/verify/schedule.hpp"

namespace hypgen {

class VerifiableInstance;

// Writes a digest for each lane of a range; false and `error` if it could not.
using Walker = std::function<bool(const DigestRange&, std::uint64_t* digests, std::string& error)>;

// Told how many lanes are done; always by the thread that has asked for the digests.
using WalkProgress = std::function<void(std::uint32_t)>;

// What comparing two walkers came to.
struct WalkComparison {
  std::uint32_t differing = 0;  // lanes
  std::uint32_t lane = 0;       // the first of them
  std::uint32_t step = 0;       // its first step after which the digests differ
};

// The digests of a range on the host, with one warp or with several; lanes are spread over threads. `fault`
// is the one of the lowest lane, if there is any.
std::vector<std::uint64_t> walk_on_host(const VerifiableInstance& instance, const DigestRange& range,
                                        int warps, std::size_t threads, const WalkProgress& progress,
                                        ScheduleFault& fault);

// Compares the digests of a range and walks the first lane that differs again, to find the step. False and
// `error` if a walker could not.
bool compare_walks(const DigestRange& range, const std::vector<std::uint64_t>& expected,
                   const std::vector<std::uint64_t>& found, const Walker& reference, const Walker& walker,
                   WalkComparison& comparison, std::string& error);

}  // namespace hypgen
