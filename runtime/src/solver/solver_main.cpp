// SPDX-License-Identifier: Apache-2.0
#include "hypgen/solver/solver_main.hpp"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "hypgen/core/interrupt.hpp"
#include "hypgen/core/progress.hpp"
#include "hypgen/episode/episode.hpp"
#include "hypgen/model/params.hpp"
#include "hypgen/solver/device_choice.hpp"
#include "hypgen/solver/json_lines.hpp"
#include "hypgen/solver/options.hpp"
#include "hypgen/solver/run_report.hpp"
#include "hypgen/solver/step_details.hpp"

namespace hypgen {

namespace {

constexpr int kDone = 0, kFailed = 1, kWrongUse = 2, kBrokenModel = 2, kInterrupted = 130;

int complain(const ModelDescriptor& model, const std::string& message, int code) {
  std::fprintf(stderr, "%s: %s\n", model.name.c_str(), message.c_str());
  return code;
}

void tell_of_threads(const ModelDescriptor& model, std::size_t searching, std::size_t asked) {
  if (searching >= asked) return;
  complain(model,
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
    complain(model, lost, kFailed);
    return nullptr;
  }
  try {
    auto made = instance.make_evaluator(evaluator_options(options.planner, model));
    complain(model, lost + "; planning on the CPU", kDone);
    tell_of_threads(model, made->threads(), options.planner.threads);
    return made;
  } catch (const std::bad_alloc&) {
    complain(model, lost + ", and there is no memory to plan on the CPU; the default policy acts", kDone);
    return nullptr;
  }
}

// How the belief is kept. The default policy reads what is visible and remembered alone, so that nothing else has
// to be kept where it acts all the time, unless the user asks for a belief or for an end where it fails.
BeliefKind belief_kind(const SolverOptions& options) {
  const bool is_read = options.planner.mode != Mode::kDefault || options.stop_on_depletion;
  return is_read || options.belief != BeliefKind::kAuto ? options.belief : BeliefKind::kVisible;
}

// Runs the episodes and prints what they add up to. The planner believes `instance`; what happens is `truth`.
int run(const ModelDescriptor& model, const ModelInstance& instance, const ModelInstance& truth,
        const SolverOptions& options) {
  JsonLines lines(model);
  if (!options.json_file.empty() && !lines.open(options.json_file)) {
    return complain(model, options.json_file + ": cannot be written", kFailed);
  }
  const PlannerOptions& planning = options.planner;
  const auto belief = instance.make_belief(planning.seed, options.particles, belief_kind(options));
  const auto world = truth.make_world(planning.seed);
  ChosenEvaluator chosen = choose_evaluator(model, instance, options);
  if (!chosen.problem.empty()) {
    if (options.require_gpu) return complain(model, chosen.problem, kFailed);
    complain(model, chosen.problem + "; planning on the CPU", kDone);
  }
  Planner planner(std::move(chosen.evaluator), model, planning);
  bool ends = false;  // for want of the GPU that is required
  planner.set_fallback(
      [&](const std::string& problem) { return cpu_fallback(model, instance, options, problem, ends); });
  planner.prepare(*belief);
  tell_of_threads(model, planner.threads(), planning.threads);

  catch_interrupts();
  const int steps = model.horizon > 0 ? std::min(model.horizon, options.steps) : options.steps;
  EpisodeLimits limits{steps, model.discount, [&] { return ends || interrupted(); },
                       options.stop_on_depletion};
  limits.period = planning.period;
  StepDetails details;
  if (options.details) {
    limits.decided = [&](const Decision& decision) {
      details = step_details(model, *belief, planner, decision);
    };
  }
  RunTotals totals;
  {
    Progress progress(options.runs, steps, !options.quiet);
    lines.write_run(options, chosen.device, planner.threads());
    totals.mode = mode_name(planning.mode);
    totals.period = planning.period;
    totals.threads = planner.threads();
    totals.in_flight = planning.in_flight;
    const auto report = [&](const StepRecord& step) {
      totals.add(step);
      lines.write(step, options.details ? &details : nullptr);
      progress.update(step.episode - options.first_run, step.step, totals.returns.mean());
    };
    const auto report_start = [&](const StartRecord& start) {
      totals.add(start);
      lines.write(start);
    };
    for (std::uint64_t run = 0; run < options.runs && !ends && !interrupted(); ++run) {
      const EpisodeRecord record = run_episode(planner, *belief, *world, model.visible_count,
                                               options.first_run + run, limits, report, report_start);
      lines.write(record);
      if (record.status == Status::kInterrupted) break;  // half an episode has no return
      totals.add(record);
    }
    totals.evaluator = planner.evaluator_stats();
    lines.write_summary(totals, planner.leaf_sizes());
  }
  std::FILE* const out = options.json_file == "-" ? stderr : stdout;
  if (!options.quiet) std::fputs(table(totals, model, planner.leaf_sizes()).c_str(), out);
  if (planning.signature)
    std::fprintf(out, "signature %016llx\n", static_cast<unsigned long long>(totals.signature));
  if (!lines.complete())
    return complain(model, options.json_file + ": some lines could not be written", kFailed);
  if (ends) return kFailed;
  if (interrupted()) return kInterrupted;
  if (totals.broken == 0) return kDone;
  // The table has told it already.
  if (options.quiet) {
    for (const std::string& line : faults(totals, model)) complain(model, line, kBrokenModel);
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

int solve(const ModelDescriptor& model, int argc, char** argv) {
  SolverOptions options;
  std::string error;
  if (!parse_options(argc, argv, this_machine(model.device), options, error))
    return complain(model, error, kWrongUse);
  if (options.help) {
    std::fputs(help_text(model, argv[0]).c_str(), stdout);
    return kDone;
  }
  if (options.version) {
    std::printf("%s (model %s, descriptor %d)\n", model.name.c_str(), model.hash.c_str(), model.version);
    return kDone;
  }
  if (options.belief == BeliefKind::kFactored && !model.factored) {
    return complain(model, "--belief: this model's belief does not factor; hypgen explain says why",
                    kWrongUse);
  }
  ParamValues values(model.params);
  const auto instance = create_instance(model, options.param_file, values, error);
  if (!instance) return complain(model, error, kWrongUse);
  ParamValues planned = values;
  if (!read_plan_params(options.plan_params, model.params, planned, error))
    return complain(model, error, kWrongUse);
  const auto planning = options.plan_params.empty() ? nullptr : model.create(planned, error);
  if (!planning && !options.plan_params.empty()) return complain(model, error, kWrongUse);
  const ModelInstance& believed = planning ? *planning : *instance;
  if (options.world_param_file.empty()) return run(model, believed, *instance, options);
  const auto truth = create_instance(model, options.world_param_file, values, error);
  return truth ? run(model, believed, *truth, options)
               : complain(model, "--world-param: " + error, kWrongUse);
}

}  // namespace

int solver_main(const ModelDescriptor& descriptor, int argc, char** argv) {
  try {
    return solve(descriptor, argc, argv);
  } catch (const std::bad_alloc&) {
    return complain(descriptor, "not enough memory; --memory, --particles and --scenarios lower the need",
                    kFailed);
  } catch (const std::exception& problem) {
    return complain(descriptor, std::string("internal error: ") + problem.what(), kFailed);
  }
}

}  // namespace hypgen
