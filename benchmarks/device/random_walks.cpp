// SPDX-License-Identifier: Apache-2.0
// Walks through random models on a GPU against the same walks on the host: prints what differs, and how much
// was compared.
#include "random_walks.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "hypgen/verify/digest_walks.hpp"

namespace random_walks {
namespace {

struct Size {
  std::uint32_t lanes = 10'000;
  std::uint32_t steps = 100;
  std::uint64_t seed = 0;
};

// What was compared so far.
struct Totals {
  std::uint64_t alone = 0;      // steps by one warp
  std::uint64_t together = 0;   // steps that warps shared
  std::uint64_t differing = 0;  // lanes
  int failed = 0;               // comparisons that could not be made
};

// Compares the walks of one model, its steps by `warps` warps, with the host's.
void compare(const Entry& model, const Walks& walks, const hypgen::DigestRange& range, int warps,
             const std::vector<std::uint64_t>& expected, Totals& totals) {
  const hypgen::Walker host = [&](const hypgen::DigestRange& lanes, std::uint64_t* digests, std::string&) {
    walks.digests(lanes, 1, digests);
    return true;
  };
  const hypgen::Walker device = [&](const hypgen::DigestRange& lanes, std::uint64_t* digests,
                                    std::string& error) {
    return walks.device_digests(lanes, warps, digests, error);
  };
  std::vector<std::uint64_t> found(range.lanes);
  hypgen::WalkComparison comparison;
  std::string error;
  if (!device(range, found.data(), error) ||
      !hypgen::compare_walks(range, expected, found, host, device, comparison, error)) {
    ++totals.failed;
    std::printf("%s, %d warps: %s\n", model.name.c_str(), warps, error.c_str());
    return;
  }
  (warps == 1 ? totals.alone : totals.together) += std::uint64_t{range.lanes} * range.steps;
  totals.differing += comparison.differing;
  if (comparison.differing == 0) return;
  std::printf("%s, %d warps: %u lanes differ, the first is lane %u, at step %u\n", model.name.c_str(), warps,
              comparison.differing, comparison.lane, comparison.step);
}

void compare(const Entry& model, const Size& size, Totals& totals) {
  std::string error;
  const std::unique_ptr<Walks> walks = model.make(model.params, error);
  if (!walks) {
    ++totals.failed;
    std::printf("%s: %s\n", model.name.c_str(), error.c_str());
    return;
  }
  const hypgen::StreamKey key = hypgen::derive(size.seed, hypgen::StreamKind::kTest, 0);
  const hypgen::DigestRange range{key, 0, size.lanes, size.steps};
  const std::size_t threads = std::max(1U, std::thread::hardware_concurrency());
  hypgen::ScheduleFault none;
  const auto expected = hypgen::walk_on_host(*walks, range, 1, threads, [](std::uint32_t) {}, none);
  compare(model, *walks, range, 1, expected, totals);
  if (model.most_warps > 1) compare(model, *walks, range, model.most_warps, expected, totals);
}

bool read(int argc, char** argv, Size& size) {
  for (int i = 1; i < argc; i += 2) {
    if (i + 1 == argc) return false;
    const std::uint64_t value = std::strtoull(argv[i + 1], nullptr, 10);
    if (std::strcmp(argv[i], "--seed") == 0) {
      size.seed = value;
    } else if (value > 0 && value <= 100'000'000 && std::strcmp(argv[i], "--lanes") == 0) {
      size.lanes = static_cast<std::uint32_t>(value);
    } else if (value > 0 && value <= 100'000'000 && std::strcmp(argv[i], "--steps") == 0) {
      size.steps = static_cast<std::uint32_t>(value);
    } else {
      return false;
    }
  }
  return true;
}

}  // namespace
}  // namespace random_walks

int main(int argc, char** argv) {
  using namespace random_walks;
  Size size;
  if (!read(argc, argv, size)) {
    std::fprintf(stderr, "usage: %s [--lanes N] [--steps T] [--seed S]\n", argv[0]);
    return 2;
  }
  Totals totals;
  const std::vector<Entry> models = entries();
  for (const Entry& model : models) {
    compare(model, size, totals);
    std::fflush(stdout);
  }
  std::printf(
      "%zu models, steps compared: %llu by one warp, %llu by several; differing lanes: %llu; failed: %d\n",
      models.size(), static_cast<unsigned long long>(totals.alone),
      static_cast<unsigned long long>(totals.together), static_cast<unsigned long long>(totals.differing),
      totals.failed);
  return totals.differing == 0 && totals.failed == 0 ? 0 : 1;
}
