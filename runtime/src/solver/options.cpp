// SPDX-License-Identifier: Apache-2.0
#include "hypgen/solver/options.hpp"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>
#include <vector>

#include "hypgen/leaves/device.hpp"
#include "hypgen/solver/device_choice.hpp"
#include "option_table.hpp"
#include "settings.hpp"

namespace hypgen {

namespace {

constexpr double kDefaultTime = 0.1;
constexpr std::size_t kGpuInFlight = 64, kHypInFlight = 256;
constexpr double kPomcpExploration = 0.3;  // docs/results/threads.md

bool read_mode(const std::string& text, Mode& mode) {
  for (const Mode candidate : {Mode::kDespot, Mode::kParallel, Mode::kGpu, Mode::kHyp, Mode::kPomcp,
                               Mode::kRollout, Mode::kDefault}) {
    if (text == mode_name(candidate)) {
      mode = candidate;
      return true;
    }
  }
  return false;
}

bool read_observations(const std::string& text, Observations& way) {
  if (text == "exact") way = Observations::kExact;
  if (text == "weighted") way = Observations::kWeighted;
  return text == "exact" || text == "weighted";
}

bool read_pruning(const std::string& text, double& lambda) {
  lambda = kAutoPruning;
  return text == "auto" || read_double(text, 0.0, 1e9, lambda);
}

bool read_on_depletion(const std::string& text, bool& stop) {
  stop = text == "stop";
  return stop || text == "continue";
}

// A GPU fills memory many times faster.
std::size_t default_memory(const SolverOptions& options) {
  constexpr std::size_t kGibibyte = std::size_t{1} << 30;
  if (!wants_device(options)) return kGibibyte;
  const auto machine =
      static_cast<std::size_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::size_t>(sysconf(_SC_PAGE_SIZE));
  return std::clamp(machine / 8, kGibibyte, 8 * kGibibyte);
}

std::size_t default_in_flight(const SolverOptions& options) {
  const Mode mode = options.planner.mode;
  if (mode == Mode::kHyp) return kHypInFlight;
  const bool is_pomcp_on_gpu = mode == Mode::kPomcp && wants_device(options);
  return mode == Mode::kGpu || is_pomcp_on_gpu ? kGpuInFlight : options.planner.threads;
}

// The mode that makes the most of the machine. One that is asked for a signature has a single thread and no
// GPU's trials in flight, so that it gives the same one everywhere.
Mode default_mode(const SolverOptions& options, const Machine& machine) {
  if (options.planner.signature || options.help || options.version) return Mode::kDespot;
  const bool is_asked_for = options.device == DeviceKind::kCuda || options.require_gpu;
  const bool has_gpu = is_asked_for || (options.device == DeviceKind::kAuto && machine.has_gpu());
  const std::size_t threads = options.planner.threads > 0 ? options.planner.threads : machine.cores;
  if (has_gpu) return threads > 1 ? Mode::kHyp : Mode::kGpu;
  return threads > 1 ? Mode::kParallel : Mode::kDespot;
}

// Fills in what the command line has left open; false and `error` if what it says contradicts itself.
bool complete(SolverOptions& options, bool has_mode, const Machine& machine, std::string& error) {
  PlannerOptions& planner = options.planner;
  if (!has_mode) planner.mode = default_mode(options, machine);
  if (planner.memory_bytes == 0) planner.memory_bytes = default_memory(options);
  if (planner.threads == 0) planner.threads = has_many_threads(planner.mode) ? machine.cores : 1;
  if (!has_mode && planner.signature && planner.threads > 1) {
    error =
        "--signature: trees of several threads differ from run to run; leave out --threads or name a --mode";
    return false;
  }
  if (options.require_gpu && options.device == DeviceKind::kCpu) {
    error = "--require-gpu: contradicts --device cpu";
    return false;
  }
  if (options.require_gpu && (planner.mode == Mode::kRollout || planner.mode == Mode::kDefault)) {
    error = std::string("--require-gpu: mode ") + mode_name(planner.mode) + " does not use a GPU";
    return false;
  }
  if (planner.threads > 1 && !may_have_threads(planner.mode)) {
    error = std::string("--threads: mode ") + mode_name(planner.mode) +
            " searches with one; modes parallel, hyp and pomcp with several";
    return false;
  }
  const bool weighs = planner.observations == Observations::kWeighted;
  if (weighs && planner.mode == Mode::kPomcp) {
    error = "--observations: mode pomcp follows single observations";
    return false;
  }
  if (planner.mode == Mode::kPomcp && planner.pruning > 0.0) {
    error = "--pruning: mode pomcp has no regularisation";
    return false;
  }
  if (planner.exploration < 0.0) planner.exploration = planner.mode == Mode::kPomcp ? kPomcpExploration : 0.0;
  if (planner.in_flight == 0) planner.in_flight = default_in_flight(options);
  planner.in_flight = std::max(planner.in_flight, planner.threads);  // a thread without a trial does nothing
  for (const auto& [name, given] :
       {std::pair("--world-param", &options.world_param_file), std::pair("--start", &options.start_file)}) {
    if (!options.serve || given->empty()) continue;
    error = std::string(name) + ": it is for the world of episodes, and there are none to play";
    return false;
  }
  if (options.serve && !options.json_file.empty()) {
    error = "--serve: it answers requests on standard output; leave out --json";
    return false;
  }
  if (options.serve && !options.record_file.empty()) {
    error = "--serve: it plays no episodes to record; leave out --record";
    return false;
  }
  if (planner.period > 0.0) {
    if (!std::isinf(planner.time_limit)) {
      error = "--period: it sets the time of each plan, so leave out --time";
      return false;
    }
    planner.time_limit = planner.period;
  }
  const bool unlimited = std::isinf(planner.time_limit);
  if (unlimited && planner.trial_limit == UINT64_MAX) planner.time_limit = kDefaultTime;
  return true;
}

std::vector<Option> option_table(SolverOptions& options) {
  PlannerOptions& planner = options.planner;
  return {
      {"--mode", "MODE",
       "despot (regularised DESPOT), parallel (the same by several threads: two runs differ), gpu (on a GPU, "
       "with many trials in flight), hyp (HyP-DESPOT: several threads and a GPU), pomcp (POMCP), "
       "rollout (one-ply rollouts) or default (the default policy) (hyp with a GPU, parallel with two cores "
       "or more, else despot; gpu or despot for --threads 1, despot for --signature)",
       "despot, parallel, gpu, hyp, pomcp, rollout or default",
       [&](const std::string& text) { return read_mode(text, planner.mode); }},
      integer("--runs", "N", "episodes to run (10)", 1, kMillion, options.runs),
      integer("--first-run", "N",
              "number of the first episode: episode i of a seed is the same in every run (0)", 0,
              1000 * kMillion, options.first_run),
      integer("--steps", "N", "most steps of an episode (90)", 1, kMillion, options.steps),
      number("--time", "SECONDS", "time to plan a step (0.1; no limit if --trials is given)", 1e-4, 1e6,
             planner.time_limit),
      number("--period", "SECONDS",
             "in place of --time: what the update of the belief and the plan after it take together, as a "
             "robot's "
             "control loop does",
             1e-4, 1e6, planner.period),
      integer(
          "--trials", "N",
          "most trials a step; without --time, results of modes with one thread repeat exactly (no limit)", 1,
          UINT64_MAX, planner.trial_limit),
      integer("--threads", "N", "threads of modes parallel and hyp (one for each core); of mode pomcp (1)", 1,
              kMostThreads, planner.threads),
      integer("--in-flight", "F",
              "trials at a time, at least one a thread (64 in mode gpu and of pomcp on a GPU, 256 in mode "
              "hyp, otherwise one a thread)",
              1, 4096, planner.in_flight),
      number("--observation-loss", "C", "how far trials in flight keep apart, of the root's gap (1)", 0.0,
             1e3, planner.observation_loss),
      number(
          "--exploration", "C",
          "how far actions that few trials took are preferred, of the root's gap (0: not at all; 0.3 in mode "
          "pomcp)",
          0.0, 1e3, planner.exploration),
      {"--device", "DEVICE",
       "where leaves are expanded: auto (a GPU in modes gpu and hyp, and with --require-gpu), cpu, cuda or "
       "cuda:N (auto)",
       "auto, cpu, cuda or cuda:N",
       [&](const std::string& text) { return read_device(text, options.device, options.device_index); }},
      toggle("--require-gpu", "end with an error rather than plan on the CPU", options.require_gpu),
      integer("--scenarios", "K", "scenarios of a search, at most 16384 (500)", 1, 1 << 14,
              planner.scenarios),
      integer(
          "--rollouts", "M",
          "actions of a leaf that are rolled out, besides the default policy's: those that promise most (3; "
          "at the root 16 or more)",
          1, 1 << 20, planner.rolled),
      {"--lanes", "WAY",
       "how the CPU plays rollouts: auto (side by side, where the model and the processor allow it) or 0 "
       "(one after "
       "the other); results are the same (auto)",
       "auto or 0",
       [&](const std::string& text) {
         planner.lanes = text == "auto";
         return planner.lanes || text == "0";
       }},
      integer("--depth", "D", "depth limit of a search (90)", 1, 10000, planner.depth),
      {"--observations", "WAY",
       "how a tree branches on what is seen: exact (scenarios that see the same stay together) or weighted "
       "(a few observations share all scenarios, by how likely they are; for many observations) (exact)",
       "exact or weighted",
       [&](const std::string& text) { return read_observations(text, planner.observations); }},
      number("--xi", "RATIO", "gap that a trial aims at, relative to the root's (0.95)", 0.0, 1.0,
             planner.target_ratio),
      {"--pruning", "LAMBDA",
       "regularisation: what a node must be worth, or auto: within a time limit, as much as luck gives one "
       "scenario, "
       "where scenarios soon see different things (auto)",
       "auto or a number from 0 to 1e9",
       [&](const std::string& text) { return read_pruning(text, planner.pruning); }},
      belief_kind(options.belief),
      particles(options.particles),
      mebibytes("--memory",
                "memory of a search in MiB (1024; in modes gpu and hyp an eighth of what the machine has)",
                planner.memory_bytes),
      mebibytes("--device-memory", "memory on the GPU in MiB (half of what is free, at most 8192)",
                planner.device_memory_bytes),
      {"--on-depletion", "WAY", "where no particle explains what was seen: continue or stop (continue)",
       "continue or stop",
       [&](const std::string& text) { return read_on_depletion(text, options.stop_on_depletion); }},
      integer("--seed", "N", "seed of all random numbers (0)", 0, UINT64_MAX, planner.seed),
      toggle("--serve", "be an agent: answer requests on standard input, a JSON object a line",
             options.serve),
      {"--settings", "FILE",
       "JSON file of options and of params to plan with, as hypgen tune writes it, or its text; what else is "
       "given "
       "goes first",
       "a file's name or a JSON object",
       [&](const std::string& text) {
         options.settings = text;
         return !text.empty();
       }},
      file("--param", "JSON file that sets the model's params", options.param_file),
      file("--world-param",
           "JSON file of params for the world that is played in, where the model's are wrong",
           options.world_param_file),
      file("--start",
           "JSON file of the state that each episode starts in: variables by name; what it leaves out is "
           "drawn",
           options.start_file),
      file("--json", "write a JSON line for each step, episode and the whole run; - for standard output",
           options.json_file),
      file(
          "--record",
          "write all of each step as a JSON line, to look at: the true state, the belief (also 200 states of "
          "it), "
          "the top of the tree. Written after the decision, often 1 MB a step, and takes time of its own",
          options.record_file),
      toggle("--details",
             "steps in the lines of --json tell the likeliest values of hidden variables, and the bounds and "
             "visits of the root's actions",
             options.details),
      toggle("--quiet", "no table, no progress", options.quiet),
      toggle("--signature", "print a hash of all search trees; mode despot unless another is given",
             planner.signature),
      toggle("--help", "print this and exit", options.help),
      toggle("--version", "print the model and its hash and exit", options.version),
  };
}

}  // namespace

bool read_device(const std::string& text, DeviceKind& kind, int& index) {
  const std::string numbered = "cuda:";
  kind = text == "auto" ? DeviceKind::kAuto : text == "cpu" ? DeviceKind::kCpu : DeviceKind::kCuda;
  index = kFirstDevice;
  if (kind != DeviceKind::kCuda || text == "cuda") return true;
  return text.rfind(numbered, 0) == 0 && read_integer(text.substr(numbered.size()), 0, 1023, index);
}

const char* mode_name(Mode mode) {
  switch (mode) {
    case Mode::kDespot:
      return "despot";
    case Mode::kParallel:
      return "parallel";
    case Mode::kGpu:
      return "gpu";
    case Mode::kHyp:
      return "hyp";
    case Mode::kPomcp:
      return "pomcp";
    case Mode::kRollout:
      return "rollout";
    case Mode::kDefault:
      return "default";
  }
  return "unknown";
}

Machine this_machine(const DeviceSupport* device) {
  cpu_set_t cores;  // those that the process may use
  const bool is_known = sched_getaffinity(0, sizeof cores, &cores) == 0;
  const int count = is_known ? CPU_COUNT(&cores) : static_cast<int>(std::thread::hardware_concurrency());
  const auto has_gpu = [device] {
    std::string problem;
    return device != nullptr && !device->devices(problem).empty();
  };
  return {static_cast<std::size_t>(std::clamp<int>(count, 1, kMostThreads)), has_gpu};
}

bool parse_options(int argc, const char* const* argv, const Machine& machine, SolverOptions& options,
                   std::string& error) {
  const std::vector<Option> table = option_table(options);
  options.planner.in_flight = options.planner.threads = options.planner.memory_bytes = 0;
  options.planner.exploration = -1.0;
  std::vector<std::string> given;
  if (!read_options(table, argc, argv, given, error)) return false;
  if (!options.settings.empty() && !take_settings(options.settings, table, given, options.plan_params, error))
    return false;
  const bool has_mode = std::find(given.begin(), given.end(), "--mode") != given.end();
  if (!complete(options, has_mode, machine, error)) return false;
  if (options.record_file == "-") {
    error = "--record: expected a file; standard output is for --json -";
    return false;
  }
  if (options.details && options.json_file.empty()) {
    error = "--details: goes to the lines of --json FILE, which is not given";
    return false;
  }
  return true;
}

std::string help_text(const ModelDescriptor& model, const std::string& program) {
  SolverOptions defaults;
  std::string text = "Plans online for the POMDP " + model.name +
                     " and acts in a simulated world.\n\nUsage: " + program +
                     " [options]\n\nOptions (defaults in brackets):\n";
  text += help_lines(option_table(defaults));
  text += "\nWith the defaults, an episode of 90 steps takes 9 seconds.\n\nExamples:\n  " + program +
          " --runs 1 --time 1 --json run.jsonl\n  " + program +
          " --mode despot --trials 500 --seed 7 --signature\n  " + program + " --mode default --runs 1000\n";
  text += help_params(model);
  return text;
}

}  // namespace hypgen
