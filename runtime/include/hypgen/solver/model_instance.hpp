// SPDX-License-Identifier: Apache-2.0
// Ties a model's type to the runtime: what a generated main file includes.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hypgen/belief/factored_belief.hpp"
#include "hypgen/belief/particle_belief.hpp"
#include "hypgen/belief/visible_belief.hpp"
#include "hypgen/episode/world.hpp"
#include "hypgen/episode/worlds.hpp"
#include "hypgen/leaves/cpu_evaluator.hpp"
#include "hypgen/leaves/hybrid_evaluator.hpp"
#include "hypgen/leaves/scenario_walk.hpp"
#include "hypgen/model/descriptor.hpp"
#include "hypgen/model/model_contract.hpp"
#include "hypgen/model/type_facts.hpp"

namespace hypgen {

// Owns a model's params; must outlive what it makes. `Interface`: ModelInstance, or one that adds to it.
template <class M, class Interface = ModelInstance>
class TypedInstance : public Interface {
 public:
  explicit TypedInstance(std::unique_ptr<typename M::Params> params) : params_(std::move(params)) {}

  std::unique_ptr<LeafEvaluator> make_evaluator(const EvaluatorOptions& options) const override {
    return std::make_unique<CpuEvaluator<M>>(*params_, options);
  }

  std::unique_ptr<LeafEvaluator> add_host(std::unique_ptr<LeafEvaluator> device,
                                          const EvaluatorOptions& options) const override {
    return std::make_unique<HybridEvaluator<M>>(*params_, options, std::move(device));
  }

  std::unique_ptr<Belief> make_belief(std::uint64_t seed, std::size_t particles,
                                      BeliefKind kind) const override {
    if (kind == BeliefKind::kVisible) return std::make_unique<VisibleBelief<M>>(*params_, seed);
    if constexpr (M::kFactored) {
      if (kind != BeliefKind::kParticle)
        return std::make_unique<FactoredBelief<M>>(*params_, seed, particles);
    }
    return std::make_unique<ParticleBelief<M>>(*params_, seed, particles);
  }

  std::unique_ptr<World> make_world(std::uint64_t seed) const override {
    return std::make_unique<ModelWorld<M>>(*params_, seed);
  }

  std::unique_ptr<Worlds> make_worlds(std::uint64_t seed, std::size_t count,
                                      std::vector<KeyDigit> digits) const override {
    return std::make_unique<ModelWorlds<M>>(*params_, seed, count, std::move(digits));
  }

  std::unique_ptr<ScenarioWalk> walk(const ScenarioBuffer& root, StreamKey key,
                                     bool weighted) const override {
    return std::make_unique<ModelWalk<M>>(*params_, root, key, weighted);
  }

  void export_states(const ScenarioBuffer& states, std::int32_t* out) const override {
    std::vector<typename M::Fixed> fixed(states.size());
    std::vector<typename M::State> changing(states.size());
    states.copy_to(fixed.data(), changing.data());
    for (std::size_t i = 0; i < states.size(); ++i, out += M::kVariableCount)
      M::export_state(fixed[i], changing[i], out);
  }

  const void* params() const override { return params_.get(); }

 protected:
  std::unique_ptr<typename M::Params> params_;
};

// Loads the params; null and `error` if the model rejects them.
template <class M>
std::unique_ptr<ModelInstance> make_instance(const ParamValues& values, std::string& error) {
  auto params = std::make_unique<typename M::Params>();
  if (!M::load(values, *params, error)) return nullptr;
  return std::make_unique<TypedInstance<M>>(std::move(params));
}

// A descriptor with what the type knows filled in, and all that a solver makes.
template <class M>
ModelDescriptor make_descriptor() {
  static_assert(ModelContract<M>::kHolds);
  ModelDescriptor descriptor = describe<M>();
  descriptor.create = &make_instance<M>;
  return descriptor;
}

}  // namespace hypgen
