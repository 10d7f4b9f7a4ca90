// SPDX-License-Identifier: Apache-2.0
#include "hypgen/verify/digest_walks.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>

#include "hypgen/verify/verifiable_model.hpp"

namespace hypgen {

namespace {

constexpr std::uint32_t kChunk = 64;  // lanes that a thread takes at a time

bool is_fault(const ScheduleFault& fault) { return fault.kind != ScheduleFault::Kind::kNone; }

// Whether the digests of the lane's first `steps` steps are the same.
bool agree(DigestRange lane, std::uint32_t steps, const Walker& reference, const Walker& walker, bool& same,
           std::string& error) {
  lane.steps = steps;
  std::uint64_t expected = 0, found = 0;
  if (!reference(lane, &expected, error) || !walker(lane, &found, error)) return false;
  same = expected == found;
  return true;
}

}  // namespace

std::vector<std::uint64_t> walk_on_host(const VerifiableInstance& instance, const DigestRange& range,
                                        int warps, std::size_t threads, const WalkProgress& progress,
                                        ScheduleFault& fault) {
  std::vector<std::uint64_t> digests(range.lanes);
  std::atomic<std::uint32_t> next{0}, done{0};
  std::mutex faults;
  const auto work = [&](bool reports) {
    for (std::uint32_t first; (first = next.fetch_add(kChunk)) < range.lanes;) {
      DigestRange chunk = range;
      chunk.first_lane += first;
      chunk.lanes = std::min(kChunk, range.lanes - first);
      const ScheduleFault found = instance.digests(chunk, warps, digests.data() + first);
      if (is_fault(found)) {
        const std::lock_guard<std::mutex> lock(faults);
        if (!is_fault(fault) || found.lane < fault.lane) fault = found;
      }
      done += chunk.lanes;
      if (reports) progress(done);
    }
  };
  std::vector<std::thread> helpers(threads - 1);
  for (std::thread& helper : helpers) helper = std::thread(work, false);
  work(true);
  for (std::thread& helper : helpers) helper.join();
  return digests;
}

bool compare_walks(const DigestRange& range, const std::vector<std::uint64_t>& expected,
                   const std::vector<std::uint64_t>& found, const Walker& reference, const Walker& walker,
                   WalkComparison& comparison, std::string& error) {
  comparison = {};
  for (std::uint32_t i = range.lanes; i-- > 0;) {
    if (expected[i] == found[i]) continue;
    ++comparison.differing;
    comparison.lane = range.first_lane + i;
  }
  if (comparison.differing == 0) return true;
  // Digests that differ after some step differ after all later ones: the first is found by bisection.
  DigestRange lane;
  lane.key = range.key;
  lane.first_lane = comparison.lane;
  lane.lanes = 1;
  std::uint32_t same_until = 0, differ_at = range.steps;
  while (differ_at - same_until > 1) {
    const std::uint32_t middle = same_until + (differ_at - same_until) / 2;
    bool same = false;
    if (!agree(lane, middle, reference, walker, same, error)) return false;
    (same ? same_until : differ_at) = middle;
  }
  comparison.step = differ_at - 1;
  return true;
}

}  // namespace hypgen
