// SPDX-License-Identifier: Apache-2.0
// Descriptors and planners of the test models.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "hypgen/belief/belief.hpp"
#include "hypgen/episode/world.hpp"
#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/model/descriptor.hpp"
#include "hypgen/search/planner.hpp"
#include "hypgen/search/tree_check.hpp"
#include "test_models.hpp"

namespace hypgen::testing {

using SmallRockSample = RockSample<4, 3>;

// Defined for the sizes 4, 3 and 7, 8.
template <int N, int K>
ModelDescriptor rock_sample_descriptor();
ModelDescriptor tiger_descriptor();
ModelDescriptor mishaps_descriptor(double upper, int illegal_from);

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
