// SPDX-License-Identifier: Apache-2.0
#include "exact_options.hpp"

#include <sstream>
#include <vector>

#include "../solver/option_table.hpp"
#include "hypgen/exact/policy_graph.hpp"

namespace hypgen::exact {

namespace {

bool read_kinds(const std::string& text, std::vector<std::string>& kinds) {
  kinds.clear();
  std::istringstream list(text);
  for (std::string kind; std::getline(list, kind, ',');) {
    if (kind != "alpha" && kind != "qmdp" && kind != "blind") return false;
    kinds.push_back(kind);
  }
  return !kinds.empty();
}

std::vector<Option> option_table(ExactOptions& options) {
  EnumerationLimits& limits = options.limits;
  return {
      number("--time", "SECONDS", "time to solve, once all states are known (60)", 0.0, 1e9, options.time),
      number("--gap", "GAP",
             "stop where upper and lower bound are so close, relative to the value's size (0.001)", 0.0, 1e9,
             options.gap),
      mebibytes("--memory", "memory in MiB (4096)", limits.bytes),
      integer("--max-states", "N", "most states (1000000)", 1, 1000 * kMillion, limits.states),
      integer("--max-outcomes", "N",
              "most outcomes: a state, an action, an observation and a next state (100000000)", 1,
              1000 * kMillion, limits.outcomes),
      file("--param", "JSON file that sets the model's params", options.param_file),
      file("--json", "write the result as a JSON object; - for standard output", options.json_file),
      file("--policy", "write the policy there", options.policy_file),
      {"--policy-format", "FORMAT",
       "format of --policy: hypgen, or appl, which SARSOP's programs read with what hypgen export writes "
       "(hypgen)",
       "hypgen or appl",
       [&options](const std::string& text) {
         options.appl_policy = text == "appl";
         return options.appl_policy || text == "hypgen";
       }},
      integer("--graph", "N",
              "show the policy as a graph of at most N nodes, and in the object of --json (0: not at all)", 0,
              10000, options.graph),
      file("--graph-file", "write that graph, of 20 nodes without --graph, there as a JSON object",
           options.graph_file),
      file("--load-policy", "act by this policy, of either format, instead of solving",
           options.load_policy_file),
      integer("--runs", "N", "episodes to play on the exact belief; --json gets a line for each (0)", 0,
              1000 * kMillion, options.runs),
      integer("--steps", "N", "most steps of an episode (90)", 1, kMillion, options.steps),
      integer("--seed", "N", "seed of the episodes: they are those of planners with the same seed (0)", 0,
              UINT64_MAX, options.seed),
      {"--policy-kind", "LIST", "which policies play, of alpha,qmdp,blind (alpha)",
       "some of alpha,qmdp,blind",
       [&options](const std::string& text) { return read_kinds(text, options.policy_kinds); }},
      file("--dump", "write states, actions, observations and outcomes as JSON lines instead of solving",
           options.dump_file),
      toggle("--quiet", "no table, no progress", options.quiet),
      toggle("--help", "print this and exit", options.help),
      toggle("--version", "print the model and its hash and exit", options.version),
  };
}

}  // namespace

bool parse_options(int argc, const char* const* argv, ExactOptions& options, std::string& error) {
  std::vector<std::string> given;
  if (!read_options(option_table(options), argc, argv, given, error)) return false;
  if (!options.graph_file.empty() && options.graph == 0) options.graph = WalkLimits().kept;
  return true;
}

std::string help_text(const ModelDescriptor& model, const std::string& program) {
  ExactOptions defaults;
  return "Enumerates the POMDP " + model.name +
         " and bounds its value from both sides.\n\nUsage: " + program +
         " [options]\n\nOptions (defaults in brackets):\n" + help_lines(option_table(defaults)) +
         "\nExamples:\n  " + program + " --gap 0.01\n  " + program + " --time 600 --json -\n" +
         help_params(model);
}

}  // namespace hypgen::exact
