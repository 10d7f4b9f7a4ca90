// SPDX-License-Identifier: Apache-2.0
#include "hypgen/solver/solver_main.hpp"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "hypgen/core/interrupt.hpp"
#include "hypgen/core/output.hpp"
#include "hypgen/core/program.hpp"
#include "hypgen/core/progress.hpp"
#include "hypgen/episode/episode.hpp"
#include "hypgen/model/params.hpp"
#include "hypgen/model/start_text.hpp"
#include "hypgen/solver/device_choice.hpp"
#include "hypgen/solver/json_lines.hpp"
#include "hypgen/solver/options.hpp"
#include "hypgen/solver/recording.hpp"
#include "hypgen/solver/run_report.hpp"
#include "hypgen/solver/step_details.hpp"
#include "option_table.hpp"

namespace hypgen {

namespace {

constexpr int kBrokenModel = 2;

void tell_of_threads(const ModelDescriptor& model, std::size_t searching, std::size_t asked) {
  if (searching >= asked) return;
  complain(model.name,
           "only " + std::to_string(searching) + " of " + std::to_string(asked) +
               " threads search: the system, or --memory for their leaves, gives no more",
           kDone);
}

// What plans once a GPU is lost. Null if there is no memory for it, or where a GPU is required: the run
// `ends` then.
std::unique_ptr<LeafEvaluator> cpu_fallback(const ModelDescriptor& model, const ModelInstance& instance,
                                            const SolverOptions& options, const std::string& problem,
                                            bool& ends) {
  const std::string lost = "the GPU was lost" + (problem.empty() ? "" : " (" + problem + ")");
  ends = options.require_gpu;
  if (ends) {
    complain(model.name, lost, kFailed);
    return nullptr;
  }
  try {
    auto made = instance.make_evaluator(evaluator_options(options.planner, model));
    complain(model.name, lost + "; planning on the CPU", kDone);
    tell_of_threads(model, made->threads(), options.planner.threads);
    return made;
  } catch (const std::bad_alloc&) {
    complain(model.name, lost + ", and there is no memory to plan on the CPU; the default policy acts",
             kDone);
    return nullptr;
  }
}

// How the belief is kept. The default policy reads what is visible and remembered alone, so that nothing else has
// to be kept where it acts all the time, unless the user asks for a belief or for an end where it fails.
BeliefKind belief_kind(const SolverOptions& options) {
  const bool is_read = options.planner.mode != Mode::kDefault || options.stop_on_depletion;
  return is_read || options.belief != BeliefKind::kAuto ? options.belief : BeliefKind::kVisible;
}

// Prints the table, to standard error where JSON lines take standard output; gives the exit code.
int show(const ModelDescriptor& model, const SolverOptions& options, const RunTotals& totals,
         const std::vector<std::uint64_t>& leaf_sizes) {
  std::string text = options.quiet ? "" : table(totals, model, leaf_sizes);
  if (options.planner.signature) text += "signature " + hexadecimal(totals.signature) + "\n";
  if (options.json_file != "-") return print(model.name, text);
  std::fputs(text.c_str(), stderr);
  return kDone;
}

// What happens: the model with the world's params.
struct Truth {
  const ModelInstance& instance;
  const ParamValues& params;
};

// Runs the episodes and prints what they add up to. The planner believes `instance`; what happens is `truth`, from
// `start` on.
int run(const EmbeddedModel& embedded, const ModelInstance& instance, const Truth& truth,
        const StartValues& start, const SolverOptions& options) {
  const ModelDescriptor& model = embedded.descriptor;
  JsonLines lines(model);
  if (!options.json_file.empty() && !lines.open(options.json_file)) {
    return complain(model.name, lines.output());
  }
  const PlannerOptions& planning = options.planner;
  const auto belief = instance.make_belief(planning.seed, options.particles, belief_kind(options));
  const auto world = truth.instance.make_world(planning.seed);
  world->set_start(start);
  Recording recording({embedded, instance, *world, options});
  if (!options.record_file.empty() && !recording.open(options.record_file))
    return complain(model.name, recording.output());
  ChosenEvaluator chosen = choose_evaluator(model, instance, options);
  if (!chosen.problem.empty()) {
    if (options.require_gpu) return complain(model.name, chosen.problem, kFailed);
    complain(model.name, chosen.problem + "; planning on the CPU", kDone);
  }
  Planner planner(std::move(chosen.evaluator), model, planning);
  bool ends = false;  // for want of the GPU that is required
  planner.set_fallback(
      [&](const std::string& problem) { return cpu_fallback(model, instance, options, problem, ends); });
  planner.prepare(*belief);
  tell_of_threads(model, planner.threads(), planning.threads);

  catch_interrupts();
  const int steps = model.horizon > 0 ? std::min(model.horizon, options.steps) : options.steps;
  EpisodeLimits limits{steps, model.discount,
                       [&] { return ends || interrupted() || !lines.ok() || !recording.ok(); },
                       options.stop_on_depletion};
  limits.period = planning.period;
  StepDetails details;
  std::uint64_t episode = 0;
  int step_number = 0;  // of the next decision
  if (options.details || recording.is_open()) {
    limits.decided = [&](const Decision& decision) {
      if (options.details) details = step_details(model, *belief, planner, decision);
      recording.keep(*belief, planner, decision, episode, step_number++);
    };
  }
  RunTotals totals;
  {
    Progress progress(options.runs, steps, !options.quiet);
    lines.write_run(options, chosen.device, planner.threads());
    recording.write_run(truth.params, chosen.device, planner.threads());
    totals.mode = mode_name(planning.mode);
    totals.period = planning.period;
    totals.threads = planner.threads();
    totals.in_flight = planning.in_flight;
    const auto report = [&](const StepRecord& step) {
      totals.add(step);
      lines.write(step, options.details ? &details : nullptr);
      recording.write(step);
      progress.update(step.episode - options.first_run, step.step, totals.returns.mean());
    };
    const auto report_start = [&](const StartRecord& start) {
      totals.add(start);
      lines.write(start);
      recording.write(start);
    };
    for (std::uint64_t run = 0; run < options.runs && !limits.interrupted(); ++run) {
      episode = options.first_run + run;
      step_number = 0;
      EpisodeRecord record =
          run_episode(planner, *belief, *world, model.visible_count, episode, limits, report, report_start);
      record.visible.resize(static_cast<std::size_t>(model.visible_count));
      world->export_visible(record.visible.data());
      lines.write(record);
      recording.write(record);
      if (record.status == Status::kInterrupted) break;  // half an episode has no return
      totals.add(record);
    }
    totals.evaluator = planner.evaluator_stats();
    lines.write_summary(totals, planner.leaf_sizes());
  }
  const bool is_recorded = recording.close();
  const bool is_kept = lines.close();
  if (!is_kept && lines.output().reader_is_gone()) return kReaderIsGone;
  const int shown = show(model, options, totals, planner.leaf_sizes());
  if (!is_kept) return complain(model.name, lines.output());
  if (!is_recorded) return complain(model.name, recording.output());
  if (shown != kDone) return shown;
  if (ends) return kFailed;
  if (interrupted()) return interrupt_code();
  if (totals.broken == 0) return kDone;
  // The table has told it already.
  if (options.quiet) {
    for (const std::string& line : faults(totals, model)) complain(model.name, line, kBrokenModel);
  }
  return kBrokenModel;
}

// The model with a file's params, and for those that it leaves out the `values` from before. Null and `error` if
// they are wrong.
std::unique_ptr<ModelInstance> create_instance(const ModelDescriptor& model, const std::string& file,
                                               ParamValues& values, std::string& error) {
  if (!file.empty() && !read_param_file(file, model.params, values, error)) return nullptr;
  return check_complete(model.params, values, error) ? model.create(values, error) : nullptr;
}

int solve(const EmbeddedModel& embedded, int argc, char** argv) {
  const ModelDescriptor& model = embedded.descriptor;
  SolverOptions options;
  std::string error;
  if (!parse_options(argc, argv, this_machine(model.device), options, error))
    return complain(model.name, error, kWrongUse);
  if (options.help) return print(model.name, help_text(model, argv[0]));
  if (options.version) return print(model.name, version_text(model));
  if (options.belief == BeliefKind::kFactored && !model.factored) {
    return complain(model.name, "--belief: this model's belief does not factor; hypgen explain says why",
                    kWrongUse);
  }
  ParamValues values(model.params);
  const auto instance = create_instance(model, options.param_file, values, error);
  if (!instance) return complain(model.name, error, kWrongUse);
  ParamValues planned = values;
  if (!read_plan_params(options.plan_params, model.params, planned, error))
    return complain(model.name, error, kWrongUse);
  const auto planning = options.plan_params.empty() ? nullptr : model.create(planned, error);
  if (!planning && !options.plan_params.empty()) return complain(model.name, error, kWrongUse);
  const ModelInstance& believed = planning ? *planning : *instance;
  StartValues start;
  if (!options.start_file.empty() && !read_start_file(options.start_file, embedded, start, error))
    return complain(model.name, "--start: " + error, kWrongUse);
  if (options.world_param_file.empty()) return run(embedded, believed, {*instance, values}, start, options);
  const auto truth = create_instance(model, options.world_param_file, values, error);
  return truth ? run(embedded, believed, {*truth, values}, start, options)
               : complain(model.name, "--world-param: " + error, kWrongUse);
}

}  // namespace

int solver_main(const EmbeddedModel& model, int argc, char** argv) {
  let_writes_fail();
  try {
    return solve(model, argc, argv);
  } catch (const std::bad_alloc&) {
    return complain(model.descriptor.name,
                    "not enough memory; --memory, --particles and --scenarios lower the need", kFailed);
  } catch (const std::exception& problem) {
    return complain(model.descriptor.name, std::string("internal error: ") + problem.what(), kFailed);
  }
}

}  // namespace hypgen
