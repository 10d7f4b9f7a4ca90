// SPDX-License-Identifier: Apache-2.0
// A GPU that fails in mid-search, or with the argument `silent` one that does not answer for some seconds in
// a plan without a deadline: the plan has to end soon with a legal action, and the next ones have to use the
// CPU. For a model that searches for longer than 0.1 s before its memory is full, as rock_sample does. Built
// as leaf_evaluator.cu is, with LIBRARY the generated library.cpp of a model.
#include LIBRARY

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <hypgen/cuda/evaluator.cuh>
#include <hypgen/search/planner.hpp>
#include <thread>

namespace {

using namespace hypgen;

// Ends with an error that stays: every later call on this process's context fails, as after a fault of the
// device.
__global__ void fail_here() { asm volatile("trap;"); }

// Takes all multiprocessors for that long.
__global__ void hold(std::uint64_t nanoseconds) {
  std::uint64_t start, now;
  asm volatile("mov.u64 %0, %globaltimer;" : "=l"(start));
  do {
    asm volatile("mov.u64 %0, %globaltimer;" : "=l"(now));
  } while (now - start < nanoseconds);
}

constexpr double kPatience = 1.0;
constexpr std::uint64_t kSilence = 5'000'000'000;  // nanoseconds

void hold_all() {
  cudaDeviceProp device;
  cudaGetDeviceProperties(&device, 0);
  const int threads = device.maxThreadsPerBlock;
  hold<<<device.multiProcessorCount*(device.maxThreadsPerMultiProcessor / threads), threads>>>(kSilence);
}

void require(bool holds, const char* what) {
  if (holds) return;
  std::printf("FAILED: %s\n", what);
  std::exit(1);
}

}  // namespace

int main(int argc, char** argv) {
  const bool is_silent = argc > 1 && std::strcmp(argv[1], "silent") == 0;
  const ModelDescriptor model = descriptor();
  ParamValues values(model.params);
  std::string error;
  const auto instance = model.create(values, error);
  require(instance != nullptr, error.c_str());
  PlannerOptions options;
  options.mode = Mode::kGpu;
  options.time_limit = 0.3;
  if (is_silent) {
    options.time_limit = std::numeric_limits<double>::infinity();
    options.trial_limit = 100'000;
    options.patience = kPatience;
  }
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

  // A silent GPU fails its plan; the next one finds that it still does not answer, and the third uses the
  // CPU.
  const int last = is_silent ? 3 : 2;
  for (int step = 0; step <= last; ++step) {
    std::thread saboteur;
    if (step == 1) {
      saboteur = std::thread([is_silent] {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        if (is_silent) {
          hold_all();
        } else {
          fail_here<<<1, 1>>>();
        }
      });
    }
    const Decision decision = planner.plan(*belief, 0, step);
    if (saboteur.joinable()) saboteur.join();
    std::printf("plan %d: %s, action %d, %.3f s, %llu expansions\n", step, status_name(decision.status),
                decision.action, decision.search_seconds,
                static_cast<unsigned long long>(decision.expansions));
    require(decision.action >= 0 && world->is_legal(decision.action), "a legal action");
    const bool is_troubled = step > 0 && step < last;
    // Calls of the driver do not return while it takes a failed context down.
    const double slack = is_troubled ? 1.0 : 0.05;
    const double limit = is_silent ? (is_troubled ? kPatience : 1e9) : options.time_limit;
    require(decision.search_seconds < limit + slack, "an answer in time");
    const bool is_reported = decision.status == Status::kDeviceLost ||
                             (is_silent && step == 1 && decision.status == Status::kEvaluatorFailed);
    require(is_reported == is_troubled, "the loss is reported, until the CPU is used");
    require(decision.expansions > 0 || (is_silent && step == 2), "a search");
  }
  std::puts("passed");
  std::fflush(stdout);
  std::_Exit(0);  // what the GPU has in hand is not waited for
}
