// SPDX-License-Identifier: Apache-2.0
// Descriptors and planners of the test models.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "hypgen/search/planner.hpp"
#include "hypgen/search/tree_check.hpp"
#include "hypgen/solver/model_instance.hpp"
#include "test_models.hpp"

namespace hypgen::testing {

inline ModelDescriptor tiger_descriptor() {
  ModelDescriptor model = make_descriptor<Tiger>();
  model.name = "Tiger";
  model.hash = "0";
  model.action_names = {"listen", "open_left", "open_right"};
  model.observation_name = [](KeyWords key) { return std::string(key[0] == 0 ? "left" : "right"); };
  model.params = {{"hearing", ParamKind::kProb, 0.0, 1.0, {}, {0.85F}, {}}};
  return model;
}

using SmallRockSample = RockSample<4, 3>;

template <int N, int K>
ModelDescriptor rock_sample_descriptor() {
  ModelDescriptor model = make_descriptor<RockSample<N, K>>();
  model.name = "RockSample";
  model.hash = "0";
  model.has_success = true;
  model.action_names = {"north", "south", "east", "west", "sample"};
  for (int r = 0; r < K; ++r) model.action_names.push_back("check(" + std::to_string(r) + ")");
  model.observation_name = [](KeyWords key) { return std::to_string(key[0]); };
  return model;
}

inline ModelDescriptor mishaps_descriptor(double upper, int illegal_from) {
  ModelDescriptor model = make_descriptor<Mishaps>();
  model.name = "Mishaps";
  model.discount = 1.0;
  model.horizon = 5;
  model.action_names = {"zero", "one"};
  model.observation_name = [](KeyWords key) { return std::to_string(key[0]); };
  model.params = {{"upper", ParamKind::kFloat, -1e9, 1e9, {}, {upper}, {}},
                  {"illegal_from", ParamKind::kInt, 0, 9, {}, {static_cast<double>(illegal_from)}, {}}};
  return model;
}

// Plans, and checks the tree that the search leaves.
inline Decision checked_plan(Planner& planner, const Belief& belief, int step) {
  const Decision decision = planner.plan(belief, 0, step);
  // Only a search that has done all its trials leaves nothing in expansion.
  if (decision.late_threads == 0) {
    EXPECT_EQ(tree_fault(planner.tree(), decision.status != Status::kTrialLimit), "");
  }
  return decision;
}

// A model's parts, ready to plan for episode 0.
struct Solver {
  Solver(const ModelDescriptor& descriptor, const PlannerOptions& options, std::size_t particles = 1000,
         BeliefKind kind = BeliefKind::kAuto)
      : model(descriptor),
        instance(model.create(ParamValues(model.params), error)),
        belief(instance->make_belief(options.seed, particles, kind)),
        world(instance->make_world(options.seed)),
        planner(instance->make_evaluator(evaluator_options(options, model)), model, options) {
    std::vector<std::int32_t> visible(static_cast<std::size_t>(model.visible_count) + 1);
    world->reset(0);
    world->export_visible(visible.data());
    belief->init(visible.data(), 0);
    planner.prepare(*belief);
  }

  Decision plan(int step = 0) { return checked_plan(planner, *belief, step); }

  // Tells the belief what was done and seen.
  Status see(int action, std::uint64_t key) { return belief->update(action, words_of(key)); }

  ModelDescriptor model;
  std::string error;
  std::unique_ptr<ModelInstance> instance;
  std::unique_ptr<Belief> belief;
  std::unique_ptr<World> world;
  Planner planner;
};

// Options for a search of so many trials in little memory.
inline PlannerOptions trials(std::uint64_t count) {
  PlannerOptions options;
  options.trial_limit = count;
  options.scenarios = 100;
  options.memory_bytes = std::size_t{64} << 20;
  return options;
}

}  // namespace hypgen::testing
