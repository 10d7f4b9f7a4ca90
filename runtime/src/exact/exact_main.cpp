// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/exact_main.hpp"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <new>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "../solver/option_table.hpp"
#include "episodes.hpp"
#include "exact_options.hpp"
#include "graph_report.hpp"
#include "hypgen/core/interrupt.hpp"
#include "hypgen/core/output.hpp"
#include "hypgen/core/program.hpp"
#include "hypgen/exact/appl_policy.hpp"
#include "hypgen/exact/dump.hpp"
#include "hypgen/exact/enumeration.hpp"
#include "hypgen/exact/interval.hpp"
#include "hypgen/model/params.hpp"
#include "solve_report.hpp"

namespace hypgen::exact {

namespace {

using Clock = std::chrono::steady_clock;

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

// Of two exit codes the first that is a failure.
int first_of(int code, int other) { return code != kDone ? code : other; }

// Prints what a person reads, to standard error where JSON lines take standard output; gives the exit code.
int show(const ExactDescriptor& model, const std::string& text, const ExactOptions& options) {
  if (options.quiet) return kDone;
  if (options.json_file != "-") return print(model.descriptor.name, text);
  std::fputs(text.c_str(), stderr);
  return kDone;
}

// Writes the policy in the format that was asked for; gives an exit code.
int write(const ExactDescriptor& descriptor, const ExactModel& model, const AlphaPolicy& policy,
          const ExactOptions& options) {
  const std::string& file = options.policy_file;
  if (options.appl_policy) {
    const std::string problem = appl_policy_problem(model, policy);
    if (!problem.empty())
      return complain(descriptor.descriptor.name, file + ": not written: " + problem, kFailed);
  }
  std::ostringstream text;
  if (options.appl_policy) {
    write_appl_policy(text, descriptor, model, policy);
  } else {
    write_policy(text, model, policy);
  }
  return print(descriptor.descriptor.name, text.str(), file);
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

int write_graph(const ExactDescriptor& model, const ShownGraph& graph, const ExactOptions& options) {
  if (options.graph_file.empty()) return kDone;
  return print(model.descriptor.name, graph.json.dump() + "\n", options.graph_file);
}

// Plays what --runs asks for, says what it came to, and writes a line for each episode to the file of --json.
int play(const ExactDescriptor& model, const ExactInstance& instance, const ExactModel& matrices,
         const std::vector<NamedPolicy>& policies, const ExactOptions& options, Output& out) {
  for (const NamedPolicy& policy : policies) {
    Samples returns;
    const bool played =
        play_policy(model, instance, matrices, policy, options, returns,
                    [&](const std::string& line) { return options.json_file.empty() || out.write(line); });
    if (out.reader_is_gone()) return kReaderIsGone;
    const int shown = show(model, table(policy.first, returns), options);
    if (!out.ok()) return complain(model.descriptor.name, out);
    if (shown != kDone) return shown;
    if (!played) break;
  }
  if (!out.close()) return complain(model.descriptor.name, out);
  return interrupted() ? interrupt_code() : kDone;
}

int play_loaded(const ExactDescriptor& model, const ExactInstance& instance, const ExactModel& matrices,
                const ExactOptions& options, Output& out) {
  std::error_code problem;
  const auto status = std::filesystem::status(options.load_policy_file, problem);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))  // it may have no end
    return complain(model.descriptor.name, options.load_policy_file + ": is no regular file", kWrongUse);
  std::ifstream file(options.load_policy_file);
  if (!file) return complain(model.descriptor.name, options.load_policy_file + ": cannot be read", kWrongUse);
  try {
    const AlphaPolicy policy =
        is_appl_policy(file.peek()) ? read_appl_policy(file, model, matrices) : read_policy(file, matrices);
    const ShownGraph graph = graph_of(model, matrices, policy, options);
    const int shown = show(model, graph.text, options);
    const int written = first_of(shown, write_graph(model, graph, options));
    if (written != kDone) return written;
    return play(model, instance, matrices, {{"loaded", &policy}}, options, out);
  } catch (const PolicyError& error) {
    return complain(model.descriptor.name, options.load_policy_file + ": " + error.what(), kWrongUse);
  }
}

int run(const ExactDescriptor& model, const ExactInstance& instance, const ExactOptions& options) {
  catch_interrupts();
  SolveReport report;
  const Enumeration enumeration = enumerate_model(model, instance, options, report);
  if (enumeration.stopped) return complain(model.descriptor.name, enumeration.problem, interrupt_code());
  if (!enumeration.problem.empty()) {
    return complain(model.descriptor.name, enumeration.problem + place_of(enumeration.broken, model),
                    kFailed);
  }
  const std::string& name = model.descriptor.name;
  if (!options.dump_file.empty()) {
    Output to(options.dump_file, Output::Kind::kWhole);
    return dump(model, enumeration.model, to) ? kDone : complain(name, to);
  }
  Output out(options.json_file.empty() ? "-" : options.json_file, Output::Kind::kLines);
  if (!out.ok()) return complain(name, out);
  if (!options.load_policy_file.empty()) return play_loaded(model, instance, enumeration.model, options, out);
  const IntervalSolution solution = solve_model(enumeration.model, options);
  report.result = solution.result;
  report.first = named_decisions(model, enumeration.model, solution.first);
  const ShownGraph graph = graph_of(model, enumeration.model, solution.alpha, options);
  report.graph = graph.json;
  // One file that cannot be written does not keep what was found out of the others.
  int code = show(model, table(model.descriptor, report) + graph.text, options);
  if (!options.json_file.empty() && !out.write(json(model.descriptor, report)))
    code = first_of(code, complain(name, out));
  code = first_of(code, write_graph(model, graph, options));
  if (!options.policy_file.empty())
    code = first_of(code, write(model, enumeration.model, solution.alpha, options));
  if (code != kDone) return code;
  std::vector<NamedPolicy> policies;
  if (options.runs > 0 && solution.result.end != IntervalEnd::kStopped) {
    for (const std::string& kind : options.policy_kinds) policies.push_back(policy_named(solution, kind));
  }
  return play(model, instance, enumeration.model, policies, options, out);
}

int solve(const ExactDescriptor& model, int argc, char** argv) {
  const ModelDescriptor& descriptor = model.descriptor;
  ExactOptions options;
  std::string error;
  if (!parse_options(argc, argv, options, error)) return complain(model.descriptor.name, error, kWrongUse);
  if (options.help) return print(descriptor.name, help_text(descriptor, argv[0]));
  if (options.version) return print(descriptor.name, version_text(descriptor));
  ParamValues values(descriptor.params);
  if (!options.param_file.empty() && !read_param_file(options.param_file, descriptor.params, values, error)) {
    return complain(model.descriptor.name, error, kWrongUse);
  }
  if (!check_complete(descriptor.params, values, error))
    return complain(model.descriptor.name, error, kWrongUse);
  const auto instance = model.create(values, error);
  if (!instance) return complain(model.descriptor.name, error, kWrongUse);
  return run(model, *instance, options);
}

}  // namespace

int exact_main(const ExactDescriptor& model, int argc, char** argv) {
  let_writes_fail();
  try {
    return solve(model, argc, argv);
  } catch (const std::bad_alloc&) {
    return complain(model.descriptor.name, "not enough memory; --memory and --max-outcomes lower the need",
                    kFailed);
  } catch (const std::invalid_argument& problem) {
    return complain(model.descriptor.name, problem.what(), kWrongUse);
  } catch (const std::exception& problem) {
    return complain(model.descriptor.name, std::string("internal error: ") + problem.what(), kFailed);
  }
}

}  // namespace hypgen::exact
