// A GPU that fails in mid-search: the plan has to end soon with a legal action, and the next ones have to use
// the CPU. For a model that searches for longer than 0.1 s before its memory is full, as rock_sample does.
// Built as leaf_evaluator.cu is, with MAIN the generated main.cpp of a model.
#define main solver_entry
#include MAIN
#undef main

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <hypgen/cuda/evaluator.cuh>
#include <hypgen/planner.hpp>
#include <thread>

namespace {

using namespace hypgen;

// Ends with an error that stays: every later call on this process's context fails, as after a fault of the
// device.
__global__ void fail_here() { asm volatile("trap;"); }

void require(bool holds, const char* what) {
  if (holds) return;
  std::printf("FAILED: %s\n", what);
  std::exit(1);
}

}  // namespace

int main() {
  const ModelDescriptor model = descriptor();
  ParamValues values(model.params);
  std::string error;
  const auto instance = model.create(values, error);
  require(instance != nullptr, error.c_str());
  PlannerOptions options;
  options.mode = Mode::kGpu;
  options.time_limit = 0.3;
  options.scenarios = 200;
  options.in_flight = 64;
  const EvaluatorOptions evaluating = evaluator_options(options, model);
  const auto& params = *static_cast<const Model::Params*>(instance->params());
  auto evaluator = cuda::CudaEvaluator<Model>::make(params, evaluating, 0, error);
  require(evaluator != nullptr, error.c_str());
  Planner planner(std::move(evaluator), model, options);
  planner.set_fallback([&](const std::string& problem) {
    std::printf("the planner says: %s\n", problem.c_str());
    return instance->make_evaluator(evaluating);
  });
  const auto belief = instance->make_belief(0, 1000, BeliefKind::kAuto);
  const auto world = instance->make_world(0);
  std::vector<std::int32_t> visible(static_cast<std::size_t>(model.visible_count) + 1);
  world->reset(0);
  world->export_visible(visible.data());
  belief->init(visible.data(), 0);
  planner.prepare(*belief);

  for (int step = 0; step < 3; ++step) {
    std::thread saboteur;
    if (step == 1) {
      saboteur = std::thread([] {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        fail_here<<<1, 1>>>();
      });
    }
    const Decision decision = planner.plan(*belief, 0, step);
    if (saboteur.joinable()) saboteur.join();
    std::printf("plan %d: %s, action %d, %.3f s, %llu expansions\n", step, status_name(decision.status),
                decision.action, decision.search_seconds,
                static_cast<unsigned long long>(decision.expansions));
    require(decision.action >= 0 && world->is_legal(decision.action), "a legal action");
    // Calls of the driver do not return while it takes a failed context down.
    const double patience = step == 1 ? 1.0 : 0.05;
    require(decision.search_seconds < options.time_limit + patience, "an answer in time");
    require((decision.status == Status::kDeviceLost) == (step == 1), "the loss is reported, once");
    require(decision.expansions > 0, "a search");
  }
  std::puts("passed");
  return 0;
}
