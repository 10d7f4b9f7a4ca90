// SPDX-License-Identifier: Apache-2.0
// The leaf evaluator of one model alone, without a tree, against a bare rollout kernel of the same model.
//
// benchmarks/device/README.md says how it is built. LIBRARY is the generated library.cpp, included for the
// model's descriptor.
#include LIBRARY

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <hypgen/belief/belief.hpp>
#include <hypgen/cuda/evaluator.cuh>
#include <hypgen/model/params.hpp>

namespace {

using namespace hypgen;

// Rollouts of the default policy and nothing else: one a thread, from the root's states.
__global__ void __launch_bounds__(256)
    bare_rollouts(const Model::Params* params, const Model::Fixed* fixed, const Model::State* states,
                  const Model::History* history, const float* discounts, int count, int depth, StreamKey key,
                  float* returns, unsigned long long* steps) {
  const std::uint32_t lane = blockIdx.x * blockDim.x + threadIdx.x;
  Model::State state = states[lane % count];
  Model::History known = *history;
  float total = 0.0F;
  bool nan = false;
  int t = 0;
  for (bool going = true; going && t < depth; ++t) {
    PhiloxDraws draws(key, lane, static_cast<std::uint32_t>(t));
    going = roll_step<Model>(*params, fixed[lane % count], draws, discounts[t], state, known, total, nan);
  }
  returns[lane] = total;
  const unsigned taken = __reduce_add_sync(cuda::kAll, static_cast<unsigned>(t));
  if (threadIdx.x % cuda::kWarp == 0) atomicAdd(steps, static_cast<unsigned long long>(taken));
}

void fail(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  std::exit(1);
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double bare_steps_a_second(const ScenarioBuffer& root, const Model::Params& params, double discount,
                           int depth) {
  constexpr int kLanes = 1 << 22;
  const int count = static_cast<int>(root.size());
  std::vector<Model::Fixed> fixed(root.size());
  std::vector<Model::State> states(root.size());
  Model::History history{};
  root.copy_to(fixed.data(), states.data());
  root.copy_history_to(history);
  std::vector<float> discounts;
  double power = 1.0;
  for (int t = 0; t <= depth; ++t, power *= discount) discounts.push_back(static_cast<float>(power));
  std::string error;
  cuda::DeviceArray<Model::Params> d_params;
  cuda::DeviceArray<Model::Fixed> d_fixed;
  cuda::DeviceArray<Model::State> d_states;
  cuda::DeviceArray<Model::History> d_history;
  cuda::DeviceArray<float> d_discounts, d_returns;
  cuda::DeviceArray<unsigned long long> d_steps;
  if (!d_params.allocate(1, error) || !d_fixed.allocate(fixed.size(), error) ||
      !d_states.allocate(states.size(), error) || !d_history.allocate(1, error) ||
      !d_discounts.allocate(discounts.size(), error) || !d_returns.allocate(kLanes, error) ||
      !d_steps.allocate(1, error)) {
    fail(error);
  }
  cudaMemcpy(d_params.get(), &params, sizeof params, cudaMemcpyHostToDevice);
  cudaMemcpy(d_fixed.get(), fixed.data(), fixed.size() * sizeof fixed[0], cudaMemcpyHostToDevice);
  cudaMemcpy(d_states.get(), states.data(), states.size() * sizeof states[0], cudaMemcpyHostToDevice);
  cudaMemcpy(d_history.get(), &history, sizeof history, cudaMemcpyHostToDevice);
  cudaMemcpy(d_discounts.get(), discounts.data(), discounts.size() * sizeof(float), cudaMemcpyHostToDevice);
  double best = 0.0;
  double spent = 0.0;
  for (int repeat = 0; repeat < 5 && spent < 1.0; ++repeat) {
    cudaMemset(d_steps.get(), 0, sizeof(unsigned long long));
    cudaDeviceSynchronize();
    const Clock::time_point start = Clock::now();
    bare_rollouts<<<kLanes / 256, 256>>>(d_params.get(), d_fixed.get(), d_states.get(), d_history.get(),
                                         d_discounts.get(), count, depth, StreamKey{1, 2}, d_returns.get(),
                                         d_steps.get());
    if (cudaDeviceSynchronize() != cudaSuccess) fail(cudaGetErrorString(cudaGetLastError()));
    const double seconds = seconds_since(start);
    spent += seconds;
    unsigned long long steps = 0;
    cudaMemcpy(&steps, d_steps.get(), sizeof steps, cudaMemcpyDeviceToHost);
    best = std::max(best, static_cast<double>(steps) / seconds);
  }
  return best;
}

// What to measure: NAME=VALUE[,VALUE..] on the command line.
struct Choices {
  std::string params;  // a parameter file
  double seconds = 1.0;
  std::vector<int> scenarios{8, 32, 128, 500};
  std::vector<int> in_flight{64, 256};
  bool bare = true;           // measure the bare rollouts too
  std::size_t memory = 4096;  // MiB, pinned
  std::vector<int> warps{0};  // 0: the evaluator chooses

  bool take(const std::string& argument) {
    const std::size_t equals = argument.find('=');
    if (equals == std::string::npos) return false;
    const std::string name = argument.substr(0, equals), value = argument.substr(equals + 1);
    if (name == "params") params = value;
    if (name == "seconds") seconds = std::stod(value);
    if (name == "bare") bare = value != "0";
    if (name == "memory") memory = std::stoul(value);
    if (name == "scenarios") scenarios = numbers(value);
    if (name == "in_flight") in_flight = numbers(value);
    if (name == "warps") warps = numbers(value);
    const std::string names[] = {"params", "seconds", "bare", "memory", "scenarios", "in_flight", "warps"};
    return std::find(std::begin(names), std::end(names), name) != std::end(names);
  }

 private:
  static std::vector<int> numbers(const std::string& text) {
    std::vector<int> result;
    for (std::size_t at = 0; at < text.size(); at = text.find(',', at) + 1) {
      result.push_back(std::atoi(text.c_str() + at));
      if (text.find(',', at) == std::string::npos) break;
    }
    return result;
  }
};

struct Setting {
  std::size_t scenarios;
  std::size_t in_flight;
  int warps;
};

// The largest group of each action, if it has at least so many scenarios.
std::vector<LeafRequest> largest_groups(const LeafResult& root, std::size_t least) {
  std::vector<LeafRequest> requests;
  for (const ActionRow& row : root.actions) {
    const ChildRow* largest = nullptr;
    for (std::uint32_t i = 0; i < row.child_count; ++i) {
      const ChildRow& child = root.children[row.first_child + i];
      if (!child.terminal && (largest == nullptr || child.count > largest->count)) largest = &child;
    }
    if (largest == nullptr || largest->count < least) continue;
    requests.push_back({0, root.handle, row.action, largest->first, largest->count, 1, {}});
  }
  return requests;
}

// Expands the same kind of leaf again and again: children of the root that all scenarios fall into, or most.
void measure(const ModelDescriptor& model, const ModelInstance& instance, const Model::Params& params,
             const Setting& setting, const Choices& choices) {
  const std::size_t scenarios = setting.scenarios, in_flight = setting.in_flight;
  const int depth = 90;
  const auto belief = instance.make_belief(1, 5000, BeliefKind::kAuto);
  const auto world = instance.make_world(1);
  std::vector<std::int32_t> visible(static_cast<std::size_t>(model.visible_count) + 1);
  world->reset(0);
  world->export_visible(visible.data());
  belief->init(visible.data(), 0);
  ScenarioBuffer root;
  belief->reserve(root, scenarios);
  const StreamKey key = derive(1, StreamKind::kPlan, 0);
  belief->sample(key, 0, scenarios, root);
  EvaluatorOptions options;
  options.max_scenarios = scenarios;
  options.memory_bytes = choices.memory << 20;
  options.discount = model.discount;
  options.max_depth = depth;
  options.in_flight = in_flight;
  options.warps = setting.warps;
  std::string error;
  const auto evaluator = cuda::CudaEvaluator<Model>::make(params, options, 0, error);
  if (!evaluator) fail(error);
  const SearchSetup setup{key, depth, false, Clock::time_point::max()};

  std::vector<LeafRequest> requests;
  std::uint64_t leaves = 0, members = 0, children = 0;
  const EvaluatorStats before = evaluator->stats();
  EvaluatorStats warm = before;
  const Clock::time_point start = Clock::now();
  Clock::time_point counted = start;
  const auto restart = [&] {
    evaluator->attach(0);
    if (evaluator->begin_search(root, setup).status != Status::kOk) fail("root");
    const LeafRequest request{0, kNoHandle, 0, 0, static_cast<std::uint32_t>(scenarios), 0, {}};
    evaluator->submit(0, {&request, 1});
    LeafResult result;
    while (!evaluator->poll(0, result)) {
    }
    if (result.status != Status::kOk) fail("root");
    requests = largest_groups(result, scenarios);
    if (requests.empty()) requests = largest_groups(result, (scenarios + 1) / 2);
    if (requests.empty()) requests.push_back(request);  // the root itself, with the default action once more
  };
  restart();
  std::size_t submitted = 0, next = 0;
  bool warmed = false;
  while (seconds_since(start) < choices.seconds) {
    while (submitted < in_flight) {
      evaluator->submit(0, {&requests[next++ % requests.size()], 1});
      ++submitted;
    }
    LeafResult result;
    if (!evaluator->poll(0, result)) continue;
    --submitted;
    if (result.status == Status::kMemoryFull) {
      restart();
      submitted = 0;
      continue;
    }
    if (result.status != Status::kOk) fail(status_name(result.status));
    if (!warmed && seconds_since(start) > 0.2 * choices.seconds) {
      warmed = true;
      warm = evaluator->stats();
      counted = Clock::now();
      leaves = members = children = 0;
    }
    ++leaves;
    members += result.count;
    children += result.children.size();
  }
  const double took = seconds_since(counted);
  const EvaluatorStats stats = evaluator->stats();
  const double steps = static_cast<double>(stats.steps - warm.steps) / took;
  const double bare = choices.bare ? bare_steps_a_second(root, params, model.discount, depth) : 0.0;
  std::printf(
      "%-24s %6zu %6zu %6d %10.0f %8.1f %8.1f %10.3g %10.3g %6.1f%% %8.1f %8.2f %8.0f\n", model.name.c_str(),
      scenarios, in_flight, setting.warps, static_cast<double>(leaves) / took,
      static_cast<double>(members) / static_cast<double>(leaves),
      static_cast<double>(stats.leaves - warm.leaves) / static_cast<double>(stats.batches - warm.batches),
      steps, bare, bare > 0.0 ? 100.0 * steps / bare : 0.0,
      static_cast<double>(stats.bytes_read - warm.bytes_read) / took * 1e-6,
      (stats.kernel_seconds - warm.kernel_seconds) / took,
      static_cast<double>(children) / static_cast<double>(leaves));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  Choices choices;
  for (int i = 1; i < argc; ++i) {
    if (!choices.take(argv[i])) fail(std::string("what is ") + argv[i] + "?");
  }
  const ModelDescriptor model = descriptor();
  ParamValues values(model.params);
  std::string error;
  if (!choices.params.empty() && !read_param_file(choices.params, model.params, values, error)) fail(error);
  const auto instance = model.create(values, error);
  if (!instance) fail(error);
  const auto params = std::make_unique<Model::Params>();
  if (!Model::load(values, *params, error)) fail(error);
  std::printf("%-24s %6s %6s %6s %10s %8s %8s %10s %10s %7s %8s %8s %8s\n", "model", "K", "F", "warps",
              "leaves/s", "a leaf", "a batch", "steps/s", "bare", "ratio", "MB/s", "kernels", "children");
  for (const int scenarios : choices.scenarios) {
    for (const int in_flight : choices.in_flight) {
      for (const int warps : choices.warps) {
        measure(model, *instance, *params,
                {static_cast<std::size_t>(scenarios), static_cast<std::size_t>(in_flight), warps}, choices);
      }
    }
  }
  return 0;
}
