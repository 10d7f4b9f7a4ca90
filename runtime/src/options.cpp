#include "hypgen/options.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <vector>

namespace hypgen {

namespace {

constexpr double kDefaultTime = 0.1;

// An option: what its value must be, and where it goes. Without a metavar it is a switch.
struct Option {
  const char* name;
  const char* metavar;
  const char* help;
  std::function<bool(const std::string&)> take;
};

bool read_double(const std::string& text, double low, double high, double& out) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !(low <= value && value <= high)) return false;
  out = value;
  return true;
}

template <class T>
bool read_integer(const std::string& text, std::uint64_t low, std::uint64_t high, T& out) {
  if (text.empty() || !std::all_of(text.begin(), text.end(), [](char c) { return '0' <= c && c <= '9'; }))
    return false;
  errno = 0;
  const unsigned long long value = std::strtoull(text.c_str(), nullptr, 10);
  if (errno != 0 || value < low || value > high) return false;
  out = static_cast<T>(value);
  return true;
}

bool read_mode(const std::string& text, Mode& mode) {
  for (const Mode candidate : {Mode::kDespot, Mode::kRollout, Mode::kDefault}) {
    if (text == mode_name(candidate)) {
      mode = candidate;
      return true;
    }
  }
  return false;
}

bool read_text(const std::string& text, std::string& out) {
  out = text;
  return !text.empty();
}

bool set(bool& flag) {
  flag = true;
  return true;
}

std::vector<Option> option_table(SolverOptions& options) {
  PlannerOptions& planner = options.planner;
  TraceOptions& trace = options.trace;
  using Text = const std::string&;
  constexpr std::uint64_t kMillion = 1000000;
  return {
      {"--mode", "despot|rollout|default",
       "how to plan: regularised DESPOT, one-ply rollouts, or the default policy alone (despot)",
       [&](Text t) { return read_mode(t, planner.mode); }},
      {"--runs", "N", "episodes to run (10)",
       [&](Text t) { return read_integer(t, 1, kMillion, options.runs); }},
      {"--steps", "N", "most steps of an episode (90)",
       [&](Text t) { return read_integer(t, 1, kMillion, options.steps); }},
      {"--time", "SECONDS", "time to plan a step (0.1; no limit if --trials is given)",
       [&](Text t) { return read_double(t, 1e-4, 1e6, planner.time_limit); }},
      {"--trials", "N", "most trials a step; makes results reproducible",
       [&](Text t) { return read_integer(t, 1, UINT64_MAX, planner.trial_limit); }},
      {"--scenarios", "K", "scenarios of a search, at most 16384 (500)",
       [&](Text t) { return read_integer(t, 1, 1 << 14, planner.scenarios); }},
      {"--depth", "D", "depth limit of a search (90)",
       [&](Text t) { return read_integer(t, 1, 10000, planner.depth); }},
      {"--xi", "RATIO", "gap that a trial aims at, relative to the root's (0.95)",
       [&](Text t) { return read_double(t, 0.0, 1.0, planner.target_ratio); }},
      {"--pruning", "LAMBDA", "regularisation: what a node must be worth (0)",
       [&](Text t) { return read_double(t, 0.0, 1e9, planner.pruning); }},
      {"--particles", "N", "particles of the belief (5000)",
       [&](Text t) { return read_integer(t, 1, 10 * kMillion, options.particles); }},
      {"--memory", "MIB", "memory of a search in MiB (1024)",
       [&](Text t) {
         std::size_t mib = 0;
         if (!read_integer(t, 1, kMillion, mib)) return false;
         planner.memory_bytes = mib << 20;
         return true;
       }},
      {"--seed", "N", "seed of all random numbers (0)",
       [&](Text t) { return read_integer(t, 0, UINT64_MAX, planner.seed); }},
      {"--param", "FILE", "JSON file that sets the model's params",
       [&](Text t) { return read_text(t, options.param_file); }},
      {"--json", "FILE", "write a JSON line for each step, episode and the whole run; - for standard output",
       [&](Text t) { return read_text(t, options.json_file); }},
      {"--quiet", nullptr, "no table, no progress", [&](Text) { return set(options.quiet); }},
      {"--signature", nullptr, "print a hash of all search trees",
       [&](Text) { return set(planner.signature); }},
      {"--trace", "FILE", "write a binary trace of random walks instead of planning",
       [&](Text t) { return read_text(t, trace.file); }},
      {"--trace-scenarios", "N", "random walks of a trace (64)",
       [&](Text t) { return read_integer(t, 1, kMillion, trace.scenarios); }},
      {"--trace-steps", "T", "steps of a trace (64)",
       [&](Text t) { return read_integer(t, 1, kMillion, trace.steps); }},
      {"--help", nullptr, "print this and exit", [&](Text) { return set(options.help); }},
      {"--version", nullptr, "print the model and its hash and exit",
       [&](Text) { return set(options.version); }},
  };
}

}  // namespace

const char* mode_name(Mode mode) {
  switch (mode) {
    case Mode::kDespot:
      return "despot";
    case Mode::kRollout:
      return "rollout";
    case Mode::kDefault:
      return "default";
  }
  return "unknown";
}

bool parse_options(int argc, const char* const* argv, SolverOptions& options, std::string& error) {
  const std::vector<Option> table = option_table(options);
  for (int i = 1; i < argc; ++i) {
    std::string name = argv[i];
    const std::size_t equals = name.find('=');
    const bool joined = equals != std::string::npos;
    std::string value = joined ? name.substr(equals + 1) : "";
    name = name.substr(0, equals);
    const auto found =
        std::find_if(table.begin(), table.end(), [&](const Option& o) { return name == o.name; });
    if (found == table.end()) {
      error = "unknown option " + name + "; --help lists the options";
      return false;
    }
    if (found->metavar == nullptr && joined) {
      error = name + " takes no value";
      return false;
    }
    if (found->metavar != nullptr && !joined) {
      if (++i == argc) {
        error = name + " needs a value: " + found->metavar + ", " + found->help;
        return false;
      }
      value = argv[i];
    }
    if (!found->take(value)) {
      error = name + ": bad value \"" + value + "\"; expected " + found->metavar + ", " + found->help;
      return false;
    }
  }
  const bool unlimited = std::isinf(options.planner.time_limit);
  if (unlimited && options.planner.trial_limit == UINT64_MAX) options.planner.time_limit = kDefaultTime;
  options.trace.seed = options.planner.seed;
  return true;
}

std::string help_text(const ModelDescriptor& model, const std::string& program) {
  SolverOptions defaults;
  std::string text = "Plans online for the POMDP " + model.name +
                     " and acts in a simulated world.\n\nUsage: " + program +
                     " [options]\n\nOptions (defaults in brackets):\n";
  for (const Option& option : option_table(defaults)) {
    std::string head =
        std::string("  ") + option.name + (option.metavar ? std::string(" ") + option.metavar : "");
    head.resize(std::max<std::size_t>(head.size() + 2, 30), ' ');
    text += head + option.help + "\n";
  }
  text += "\nWith the defaults, an episode of 90 steps takes 9 seconds.\n\nExamples:\n  " + program +
          " --runs 1 --time 1 --json run.jsonl\n  " + program + " --trials 500 --seed 7 --signature\n  " +
          program + " --mode default --runs 1000\n";
  if (!model.params.empty()) {
    text += "\nParams (set by --param FILE, a JSON object):";
    for (const ParamSpec& param : model.params) text += " " + param.name;
    text += "\n";
  }
  return text;
}

}  // namespace hypgen
