// SPDX-License-Identifier: Apache-2.0
#include "hypgen/solver/device_choice.hpp"

#include <algorithm>
#include <utility>

#include "hypgen/leaves/device.hpp"

namespace hypgen {

namespace {

// Null and `problem` if there is no such GPU, or it cannot be used. `index`: the one asked for, or
// kFirstDevice; then the one taken.
std::unique_ptr<LeafEvaluator> make_on_device(const ModelDescriptor& model, const ModelInstance& instance,
                                              const SolverOptions& options, int& index,
                                              std::string& problem) {
  if (options.planner.mode == Mode::kRollout || options.planner.mode == Mode::kDefault) {
    problem = std::string("--mode ") + mode_name(options.planner.mode) + " does not use a GPU";
    return nullptr;
  }
  if (!find_device(model.device, index, problem)) return nullptr;
  const EvaluatorOptions whole = evaluator_options(options.planner, model);
  // In closed form a leaf costs a device so little that a full batch is sooner done than its share on the host.
  if (options.planner.mode != Mode::kHyp || options.planner.threads == 1 || !model.rolls_out) {
    return model.device->make_evaluator(instance.params(), whole, index, problem);
  }
  EvaluatorOptions half = whole;
  half.memory_bytes /= 2;
  auto device = model.device->make_evaluator(instance.params(), half, index, problem);
  return device ? instance.add_host(std::move(device), whole) : nullptr;
}

}  // namespace

bool find_device(const DeviceSupport* support, int& index, std::string& problem) {
  if (support == nullptr) {
    problem = "this solver was built without CUDA";
    return false;
  }
  const std::vector<DeviceInfo> devices = support->devices(problem);
  if (devices.empty()) return false;
  if (index == kFirstDevice) index = devices.front().index;
  const auto is_wanted = [=](const DeviceInfo& device) { return device.index == index; };
  if (std::any_of(devices.begin(), devices.end(), is_wanted)) return true;
  problem = "no GPU with number " + std::to_string(index) + " that this solver has code for";
  return false;
}

bool wants_device(const SolverOptions& options) {
  if (options.device == DeviceKind::kCpu) return false;
  return options.device == DeviceKind::kCuda || wants_gpu(options.planner.mode) || options.require_gpu;
}

ChosenEvaluator choose_evaluator(const ModelDescriptor& model, const ModelInstance& instance,
                                 const SolverOptions& options) {
  ChosenEvaluator chosen{nullptr, "cpu", ""};
  if (wants_device(options)) {
    int index = options.device_index;
    chosen.evaluator = make_on_device(model, instance, options, index, chosen.problem);
    if (chosen.evaluator) {
      chosen.device = "cuda:" + std::to_string(index);
      return chosen;
    }
  }
  chosen.evaluator = instance.make_evaluator(evaluator_options(options.planner, model));
  return chosen;
}

}  // namespace hypgen
