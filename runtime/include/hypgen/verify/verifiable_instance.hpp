// SPDX-License-Identifier: Apache-2.0
// Ties a model's type to the checks: what a generated verify.cpp includes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "hypgen/model/model_contract.hpp"
#include "hypgen/solver/model_instance.hpp"
#include "hypgen/verify/bounds_check.hpp"
#include "hypgen/verify/schedule.hpp"
#include "hypgen/verify/trace.hpp"
#include "hypgen/verify/verifiable_model.hpp"

namespace hypgen {

template <class M>
class TypedVerifiableInstance final : public TypedInstance<M, VerifiableInstance> {
 public:
  using TypedInstance<M, VerifiableInstance>::TypedInstance;

  bool write_trace(const TraceOptions& options, std::string& error) const override {
    return Tracer<M>(*this->params_, options).write(error);
  }

  ScheduleFault digests(const DigestRange& range, int warps, std::uint64_t* out) const override {
    return walk_lanes<M>(*this->params_, range, warps, out);
  }

  BoundsFound check_bounds(const BoundsWalk& walk) const override {
    const auto belief = this->make_belief(walk.seed, BoundsChecker<M>::kParticles, BeliefKind::kAuto);
    return BoundsChecker<M>(*this->params_, walk, *belief).run();
  }
};

// Loads the params; null and `error` if the model rejects them.
template <class M>
std::unique_ptr<VerifiableInstance> make_verifiable_instance(const ParamValues& values, std::string& error) {
  auto params = std::make_unique<typename M::Params>();
  if (!M::load(values, *params, error)) return nullptr;
  return std::make_unique<TypedVerifiableInstance<M>>(std::move(params));
}

// All that checks on the host ask of the described model.
template <class M>
VerifiableModel make_verifiable(ModelDescriptor descriptor) {
  static_assert(ModelContract<M>::kHolds);
  VerifiableModel model;
  model.descriptor = std::move(descriptor);
  if constexpr (IsPartitioned<M>::value) model.most_warps = M::kMaxWarps;
  model.create = &make_verifiable_instance<M>;
  return model;
}

}  // namespace hypgen
