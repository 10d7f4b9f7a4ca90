// SPDX-License-Identifier: Apache-2.0
// On what a solver plans: the CPU, or a GPU if it has one.
#pragma once

#include <memory>
#include <string>

#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/model/descriptor.hpp"
#include "hypgen/solver/options.hpp"

namespace hypgen {

struct ChosenEvaluator {
  std::unique_ptr<LeafEvaluator> evaluator;
  std::string device;   // "cpu" or "cuda:N"
  std::string problem;  // why it is the CPU's, where a GPU was asked for
};

// Whether the program can use GPU `index`, or any for kFirstDevice: then `index` is the first. False and `problem`
// if it cannot.
bool find_device(const DeviceSupport* support, int& index, std::string& problem);

// Whether the options ask for a GPU.
bool wants_device(const SolverOptions& options);

// The evaluator that the options ask for, or the CPU's.
ChosenEvaluator choose_evaluator(const ModelDescriptor& model, const ModelInstance& instance,
                                 const SolverOptions& options);

}  // namespace hypgen
