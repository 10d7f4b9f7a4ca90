// SPDX-License-Identifier: Apache-2.0
// The command line of a solver.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "hypgen/model/descriptor.hpp"
#include "hypgen/search/planner.hpp"

namespace hypgen {

// Where leaves are expanded; kAuto: on a GPU in modes gpu and hyp, otherwise on the CPU.
enum class DeviceKind { kAuto, kCpu, kCuda };
constexpr int kFirstDevice = -1;

struct SolverOptions {
  PlannerOptions planner;
  DeviceKind device = DeviceKind::kAuto;
  int device_index = kFirstDevice;
  bool require_gpu = false;
  std::uint64_t runs = 10;
  std::uint64_t first_run = 0;  // the number of the first episode
  int steps = 90;
  BeliefKind belief = BeliefKind::kAuto;
  std::size_t particles = 5000;
  bool stop_on_depletion = false;
  std::string settings;     // a file of settings, or its text
  std::string plan_params;  // of the settings, as JSON: what the planner has in place of the world's params
  std::string param_file;
  std::string world_param_file;  // empty: the world has the model's params
  std::string start_file;        // empty: episodes start as the world's model says
  std::string json_file;
  std::string record_file;
  bool details = false;  // of each step, in the JSON lines
  bool quiet = false;
  bool serve = false;  // an agent on standard input and output
  bool help = false;
  bool version = false;
};

// Reads the name of a device: auto, cpu, cuda (the first GPU) or cuda:N. False if it is none of these.
bool read_device(const std::string& text, DeviceKind& kind, int& index);

// What a machine has, for options that are not given.
struct Machine {
  std::size_t cores = 1;
  std::function<bool()> has_gpu = [] {
    return false;
  };  // that the solver can use; asked only where it matters
};

// The one that this process runs on. `device`: the model on GPUs; null without CUDA.
Machine this_machine(const DeviceSupport* device);

// Reads the command line; false and `error` on an unknown option or a bad value. What is not given follows
// from the rest and from the machine: the mode is the one that makes the most of it.
bool parse_options(int argc, const char* const* argv, const Machine& machine, SolverOptions& options,
                   std::string& error);

// What --help prints.
std::string help_text(const ModelDescriptor& model, const std::string& program);

const char* mode_name(Mode mode);
const char* belief_name(BeliefKind kind);

}  // namespace hypgen
