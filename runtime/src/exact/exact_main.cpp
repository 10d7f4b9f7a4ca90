// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/exact_main.hpp"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "episodes.hpp"
#include "exact_options.hpp"
#include "graph_report.hpp"
#include "hypgen/core/interrupt.hpp"
#include "hypgen/exact/appl_policy.hpp"
#include "hypgen/exact/dump.hpp"
#include "hypgen/exact/enumeration.hpp"
#include "hypgen/exact/interval.hpp"
#include "hypgen/model/params.hpp"
#include "solve_report.hpp"

namespace hypgen::exact {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kDone = 0, kFailed = 1, kWrongUse = 2, kInterrupted = 130;

int complain(const ExactDescriptor& model, const std::string& message, int code) {
  std::fprintf(stderr, "%s: %s\n", model.descriptor.name.c_str(), message.c_str());
  return code;
}

// One line on a terminal that tells how far the work is.
class StatusLine {
 public:
  explicit StatusLine(bool wanted) : shown_(wanted && isatty(STDERR_FILENO) != 0) {}
  ~StatusLine() {
    if (shown_) std::fprintf(stderr, "\r\033[K");
  }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  void show(const std::string& text) {
    const Clock::time_point now = Clock::now();
    if (!shown_ || now < next_) return;
    next_ = now + std::chrono::milliseconds(100);
    std::fprintf(stderr, "\r\033[K%s", text.c_str());
    std::fflush(stderr);
  }

 private:
  bool shown_;
  Clock::time_point next_{};
};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Enumeration enumerate_model(const ExactDescriptor& model, const ExactInstance& instance,
                            const ExactOptions& options, SolveReport& report) {
  StatusLine line(!options.quiet);
  const Clock::time_point start = Clock::now();
  Enumeration result =
      enumerate(instance.outcomes(), model.descriptor.discount, model.descriptor.horizon, options.limits,
                [&](const EnumerationCounts& counts) {
                  report.counts = counts;
                  line.show(std::to_string(counts.expanded) + " of " + std::to_string(counts.states) +
                            " states so far, " + std::to_string(counts.outcomes) + " outcomes");
                  return !interrupted();
                });
  result.model.rounding = options.param_file.empty() ? model.rounding : model.any_params;
  report.classes = result.model.classes();
  report.actions = static_cast<int>(result.model.actions.size());
  report.observations = result.model.observations;
  report.starts = result.model.starts.size();
  report.enumeration_seconds = seconds_since(start);
  return result;
}

// In which state a reward is no number, and which rewards may be none.
std::string place_of(const BrokenStep& step, const ExactDescriptor& model) {
  if (step.action < 0) return "";
  std::string text =
      "\n  where " + model.descriptor.action_names[static_cast<std::size_t>(step.action)] + " is done in";
  const std::vector<std::string> values = model.value_names(step.values.data());
  const std::vector<std::string>& names = model.descriptor.variable_names;
  for (std::size_t i = 0; i < values.size(); ++i) {
    text += (i == 0 ? " " : ", ") + (names.empty() ? "" : names[i] + "=") + values[i];
  }
  for (const std::string& term : model.descriptor.doubtful) text += "\n  what may be no number: " + term;
  return text;
}

IntervalSolution solve_model(const ExactModel& model, const ExactOptions& options) {
  StatusLine line(!options.quiet);
  IntervalOptions interval;
  interval.seconds = options.time;
  interval.gap = options.gap;
  interval.bytes = options.limits.bytes;
  return solve_interval(model, interval, [&](const IntervalResult& result) {
    line.show(status_line(result));
    return !interrupted();
  });
}

// A file, or standard output for "-".
class OutputFile {
 public:
  explicit OutputFile(const std::string& file) : out_(file == "-" ? stdout : std::fopen(file.c_str(), "w")) {}
  ~OutputFile() {
    if (out_ != nullptr && out_ != stdout) std::fclose(out_);
  }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  bool is_open() const { return out_ != nullptr; }
  // What was written before is there even if the next does not come.
  bool write(const std::string& text) {
    const bool written = std::fwrite(text.data(), 1, text.size(), out_) == text.size();
    return std::fflush(out_) == 0 && written;
  }

 private:
  std::FILE* out_;
};

// Writes the policy in the format that was asked for; gives an exit code.
int write(const ExactDescriptor& descriptor, const ExactModel& model, const AlphaPolicy& policy,
          const ExactOptions& options) {
  const std::string& file = options.policy_file;
  if (options.appl_policy) {
    const std::string problem = appl_policy_problem(model, policy);
    if (!problem.empty()) return complain(descriptor, file + ": not written: " + problem, kFailed);
  }
  std::ofstream to_file;
  if (file != "-") to_file.open(file);
  std::ostream& out = file == "-" ? std::cout : to_file;
  if (options.appl_policy) {
    write_appl_policy(out, descriptor, model, policy);
  } else {
    write_policy(out, model, policy);
  }
  return out.flush() ? kDone : complain(descriptor, file + ": cannot be written", kFailed);
}

// A policy's graph as text and as JSON; empty where none is asked for.
struct ShownGraph {
  std::string text;
  nlohmann::ordered_json json;
};

ShownGraph graph_of(const ExactDescriptor& descriptor, const ExactModel& model, const AlphaPolicy& policy,
                    const ExactOptions& options) {
  if (options.graph == 0) return {};
  WalkLimits limits;
  limits.kept = options.graph;
  const PolicyGraph graph = policy_graph(model, policy, limits);
  return {graph_text(descriptor, model, graph), graph_json(descriptor, model, graph)};
}

bool write_graph(const ShownGraph& graph, const ExactOptions& options) {
  if (options.graph_file.empty()) return true;
  OutputFile out(options.graph_file);
  return out.is_open() && out.write(graph.json.dump() + "\n");
}

// Plays what --runs asks for, says what it came to, and writes a line for each episode to the file of --json.
int play(const ExactDescriptor& model, const ExactInstance& instance, const ExactModel& matrices,
         const std::vector<NamedPolicy>& policies, const ExactOptions& options, OutputFile& out) {
  for (const NamedPolicy& policy : policies) {
    Samples returns;
    const bool played =
        play_policy(model, instance, matrices, policy, options, returns,
                    [&](const std::string& line) { return options.json_file.empty() || out.write(line); });
    if (!options.quiet) {
      std::fputs(table(policy.first, returns).c_str(), options.json_file == "-" ? stderr : stdout);
    }
    if (!played)
      return interrupted() ? kInterrupted
                           : complain(model, options.json_file + ": cannot be written", kFailed);
  }
  return kDone;
}

int play_loaded(const ExactDescriptor& model, const ExactInstance& instance, const ExactModel& matrices,
                const ExactOptions& options, OutputFile& out) {
  std::error_code problem;
  const auto status = std::filesystem::status(options.load_policy_file, problem);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))  // it may have no end
    return complain(model, options.load_policy_file + ": is no regular file", kWrongUse);
  std::ifstream file(options.load_policy_file);
  if (!file) return complain(model, options.load_policy_file + ": cannot be read", kWrongUse);
  try {
    const AlphaPolicy policy =
        is_appl_policy(file.peek()) ? read_appl_policy(file, model, matrices) : read_policy(file, matrices);
    const ShownGraph graph = graph_of(model, matrices, policy, options);
    if (!options.quiet) std::fputs(graph.text.c_str(), options.json_file == "-" ? stderr : stdout);
    if (!write_graph(graph, options))
      return complain(model, options.graph_file + ": cannot be written", kFailed);
    return play(model, instance, matrices, {{"loaded", &policy}}, options, out);
  } catch (const PolicyError& error) {
    return complain(model, options.load_policy_file + ": " + error.what(), kWrongUse);
  }
}

int run(const ExactDescriptor& model, const ExactInstance& instance, const ExactOptions& options) {
  catch_interrupts();
  SolveReport report;
  const Enumeration enumeration = enumerate_model(model, instance, options, report);
  if (enumeration.stopped) return complain(model, enumeration.problem, kInterrupted);
  if (!enumeration.problem.empty()) {
    return complain(model, enumeration.problem + place_of(enumeration.broken, model), kFailed);
  }
  const auto fail = [&](const std::string& file) {
    return complain(model, file + ": cannot be written", kFailed);
  };
  if (!options.dump_file.empty()) {
    return dump(model, enumeration.model, options.dump_file) ? kDone : fail(options.dump_file);
  }
  const std::string json_file = options.json_file.empty() ? "-" : options.json_file;
  OutputFile out(json_file);
  if (!out.is_open()) return fail(json_file);
  if (!options.load_policy_file.empty()) return play_loaded(model, instance, enumeration.model, options, out);
  const IntervalSolution solution = solve_model(enumeration.model, options);
  report.result = solution.result;
  report.first = named_decisions(model, enumeration.model, solution.first);
  const ShownGraph graph = graph_of(model, enumeration.model, solution.alpha, options);
  report.graph = graph.json;
  if (!options.quiet) {
    const std::string text = table(model.descriptor, report) + graph.text;
    std::fputs(text.c_str(), options.json_file == "-" ? stderr : stdout);
  }
  if (!options.json_file.empty() && !out.write(json(model.descriptor, report))) {
    return fail(options.json_file);
  }
  if (!write_graph(graph, options)) return fail(options.graph_file);
  if (!options.policy_file.empty()) {
    const int written = write(model, enumeration.model, solution.alpha, options);
    if (written != kDone) return written;
  }
  if (solution.result.end == IntervalEnd::kStopped) return kInterrupted;
  std::vector<NamedPolicy> policies;
  for (const std::string& kind : options.policy_kinds) policies.push_back(policy_named(solution, kind));
  return options.runs > 0 ? play(model, instance, enumeration.model, policies, options, out) : kDone;
}

int solve(const ExactDescriptor& model, int argc, char** argv) {
  const ModelDescriptor& descriptor = model.descriptor;
  ExactOptions options;
  std::string error;
  if (!parse_options(argc, argv, options, error)) return complain(model, error, kWrongUse);
  if (options.help) {
    std::fputs(help_text(descriptor, argv[0]).c_str(), stdout);
    return kDone;
  }
  if (options.version) {
    std::printf("%s (model %s, descriptor %d)\n", descriptor.name.c_str(), descriptor.hash.c_str(),
                descriptor.version);
    return kDone;
  }
  ParamValues values(descriptor.params);
  if (!options.param_file.empty() && !read_param_file(options.param_file, descriptor.params, values, error)) {
    return complain(model, error, kWrongUse);
  }
  if (!check_complete(descriptor.params, values, error)) return complain(model, error, kWrongUse);
  const auto instance = model.create(values, error);
  if (!instance) return complain(model, error, kWrongUse);
  return run(model, *instance, options);
}

}  // namespace

int exact_main(const ExactDescriptor& model, int argc, char** argv) {
  try {
    return solve(model, argc, argv);
  } catch (const std::bad_alloc&) {
    return complain(model, "not enough memory; --memory and --max-outcomes lower the need", kFailed);
  } catch (const std::invalid_argument& problem) {
    return complain(model, problem.what(), kWrongUse);
  } catch (const std::exception& problem) {
    return complain(model, std::string("internal error: ") + problem.what(), kFailed);
  }
}

}  // namespace hypgen::exact
