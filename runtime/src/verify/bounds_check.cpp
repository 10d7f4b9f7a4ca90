// SPDX-License-Identifier: Apache-2.0
#include "hypgen/verify/bounds_check.hpp"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "hypgen/core/program.hpp"

namespace hypgen {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kWalks = 64;  // whatever the number of threads, so that the figures are the same
constexpr const char* kNames[kBounds] = {"upper", "declared upper", "lower", "tail"};

// All walks, spread over threads.
BoundsFound walk_all(const ModelDescriptor& model, const VerifiableInstance& instance,
                     const BoundsCheckOptions& options) {
  BoundsFound found{};
  std::mutex guard;
  std::atomic<std::uint32_t> next{0};
  const auto work = [&] {
    for (std::uint32_t number; (number = next++) < kWalks;) {
      BoundsWalk walk;
      walk.seed = options.seed;
      walk.number = number;
      walk.beliefs = options.beliefs / kWalks + (number < options.beliefs % kWalks ? 1 : 0);
      walk.steps = options.steps;
      walk.horizon = model.horizon;
      walk.discount = model.discount;
      const BoundsFound some = instance.check_bounds(walk);
      const std::lock_guard<std::mutex> lock(guard);
      for (std::size_t i = 0; i < kBounds; ++i) found[i].add(some[i]);
    }
  };
  std::vector<std::thread> helpers(options.threads - 1);
  for (std::thread& helper : helpers) helper = std::thread(work);
  work();
  for (std::thread& helper : helpers) helper.join();
  return found;
}

double mean_room(const BoundSums& sums) { return sums.room / static_cast<double>(sums.compared); }

std::string table(const BoundsFound& found) {
  std::string text = "bound               beliefs  violations   mean room\n";
  for (std::size_t i = 0; i < kBounds; ++i) {
    if (found[i].compared == 0) continue;
    char line[128];
    std::snprintf(line, sizeof line, "%-16s %10llu  %10llu  %10.4g\n", kNames[i],
                  static_cast<unsigned long long>(found[i].compared),
                  static_cast<unsigned long long>(found[i].violations), mean_room(found[i]));
    text += line;
  }
  return text;
}

std::string json_line(const ModelDescriptor& model, const BoundsCheckOptions& options,
                      const BoundsFound& found) {
  Json bounds = Json::object();
  for (std::size_t i = 0; i < kBounds; ++i) {
    if (found[i].compared == 0) continue;
    bounds[kNames[i]] = {{"beliefs", found[i].compared},
                         {"violations", found[i].violations},
                         {"mean_room", mean_room(found[i])}};
  }
  const Json line = {{"type", "bounds"},
                     {"model", model.name},
                     {"hash", model.hash},
                     {"seed", options.seed},
                     {"bounds", bounds}};
  return line.dump() + "\n";
}

}  // namespace

int check_bounds(const ModelDescriptor& model, const VerifiableInstance& instance,
                 const BoundsCheckOptions& options) {
  const BoundsFound found = walk_all(model, instance, options);
  const bool hold =
      std::all_of(found.begin(), found.end(), [](const BoundSums& s) { return s.violations == 0; });
  const std::string text = options.json_file.empty() ? table(found) : json_line(model, options, found);
  const int printed = print(model.name, text, options.json_file.empty() ? "-" : options.json_file);
  return printed == kDone && !hold ? kFailed : printed;
}

}  // namespace hypgen
