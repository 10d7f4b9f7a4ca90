// SPDX-License-Identifier: Apache-2.0
#include "verify_options.hpp"

#include <cstdint>
#include <vector>

#include "../solver/option_table.hpp"

namespace hypgen {

namespace {

// What several checks take.
struct Shared {
  std::size_t threads = 0;
  std::uint64_t seed = 0;
  int steps = 90;
  std::string json_file;
};

std::vector<Option> option_table(VerifyOptions& options, Shared& shared) {
  TraceOptions& trace = options.trace;
  SelftestOptions& selftest = options.selftest;
  return {
      integer("--lanes", "N", "random walks to compare, each of --steps steps (1000)", 1, 100 * kMillion,
              selftest.lanes),
      integer("--warps", "W", "warps that share a step (several numbers, one after the other)", 1, 16,
              selftest.warps),
      integer("--check-bounds", "N",
              "instead, compare the bounds at so many beliefs, met along episodes, with what the default "
              "policy earns",
              1, 1000 * kMillion, options.bounds.beliefs),
      integer("--check-beliefs", "N",
              "instead, write the ranks of true values in the belief as JSON lines, over so many episodes; "
              "hypgen check --beliefs judges them",
              1, kMillion, options.beliefs.episodes),
      belief_kind(options.beliefs.belief),
      particles(options.beliefs.particles),
      file("--trace", "instead, write random walks there with all that is computed, as a binary table",
           trace.file),
      integer("--trace-scenarios", "N", "random walks of a trace (64)", 1, kMillion, trace.scenarios),
      integer("--trace-steps", "T", "steps of a trace (64)", 1, kMillion, trace.steps),
      integer("--steps", "N", "steps of a walk; most steps of an episode (90)", 1, kMillion, shared.steps),
      integer("--threads", "N", "threads (one for each core)", 1, kMostThreads, shared.threads),
      integer("--seed", "N", "seed of all random numbers (0)", 0, UINT64_MAX, shared.seed),
      file("--param", "JSON file that sets the model's params", options.param_file),
      file("--json", "write JSON lines instead of a table; - for standard output", shared.json_file),
      toggle("--quiet", "no progress", selftest.quiet),
      toggle("--help", "print this and exit", options.help),
      toggle("--version", "print the model and its hash and exit", options.version),
  };
}

}  // namespace

bool parse_options(int argc, const char* const* argv, std::size_t cores, VerifyOptions& options,
                   std::string& error) {
  Shared shared;
  shared.threads = cores;
  std::vector<std::string> given;
  if (!read_options(option_table(options, shared), argc, argv, given, error)) return false;
  const int tasks = (options.trace.file.empty() ? 0 : 1) + (options.bounds.beliefs > 0 ? 1 : 0) +
                    (options.beliefs.episodes > 0 ? 1 : 0);
  if (tasks > 1) {
    error = "--trace, --check-bounds and --check-beliefs are tasks of their own: run one after the other";
    return false;
  }
  options.selftest.threads = options.bounds.threads = options.beliefs.threads = shared.threads;
  options.trace.seed = options.selftest.seed = options.bounds.seed = options.beliefs.seed = shared.seed;
  options.selftest.steps = static_cast<std::uint32_t>(shared.steps);
  options.bounds.steps = options.beliefs.steps = shared.steps;
  options.selftest.json_file = options.bounds.json_file = options.beliefs.json_file = shared.json_file;
  return true;
}

std::string verify_help(const ModelDescriptor& model, const std::string& program) {
  VerifyOptions defaults;
  Shared shared;
  return "Checks the code of the POMDP " + model.name +
         ": compares steps as warps and as GPUs do them with plain ones.\n\nUsage: " + program +
         " [options]\n\nOptions (defaults in brackets):\n" + help_lines(option_table(defaults, shared)) +
         "\nExamples:\n  " + program + " --lanes 100000\n  " + program + " --check-bounds 10000\n" +
         help_params(model);
}

}  // namespace hypgen
