// SPDX-License-Identifier: Apache-2.0
// A random model for the host: what the units that the generator writes put into the program's registry.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/episode/world.hpp"
#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/model/descriptor.hpp"
#include "hypgen/verify/device_walk.hpp"
#include "hypgen/verify/digest.hpp"
#include "hypgen/verify/schedule.hpp"
#include "hypgen/verify/verifiable_model.hpp"

namespace random_walks {

// A model that walks and does nothing else: a program for planning with hundreds would take hours to compile.
class Walks : public hypgen::VerifiableInstance {
 public:
  std::unique_ptr<hypgen::LeafEvaluator> make_evaluator(const hypgen::EvaluatorOptions&) const override {
    return nullptr;
  }
  std::unique_ptr<hypgen::LeafEvaluator> add_host(std::unique_ptr<hypgen::LeafEvaluator>,
                                                  const hypgen::EvaluatorOptions&) const override {
    return nullptr;
  }
  std::unique_ptr<hypgen::Belief> make_belief(std::uint64_t, std::size_t, hypgen::BeliefKind) const override {
    return nullptr;
  }
  std::unique_ptr<hypgen::World> make_world(std::uint64_t) const override { return nullptr; }
  bool write_trace(const hypgen::TraceOptions&, std::string&) const override { return false; }
  hypgen::BoundsFound check_bounds(const hypgen::BoundsWalk&) const override { return {}; }

  virtual bool device_digests(const hypgen::DigestRange& range, int warps, std::uint64_t* out,
                              std::string& error) const = 0;
};

template <class M>
class TypedWalks final : public Walks {
 public:
  static std::unique_ptr<Walks> make(const hypgen::ParamValues& values, std::string& error) {
    auto walks = std::make_unique<TypedWalks>();
    if (!M::load(values, *walks->params_, error)) return nullptr;
    return walks;
  }

  // Plain steps: that parts come to the same on the host is what tests show.
  hypgen::ScheduleFault digests(const hypgen::DigestRange& range, int, std::uint64_t* out) const override {
    for (std::uint32_t i = 0; i < range.lanes; ++i) {
      hypgen::DigestLane<M> lane(*params_, range.key, range.first_lane + i);
      lane.start();
      for (std::uint32_t t = 0; t < range.steps; ++t) lane.step(t);
      out[i] = lane.value();
    }
    return {};
  }

  const void* params() const override { return params_.get(); }

  bool device_digests(const hypgen::DigestRange& range, int warps, std::uint64_t* out,
                      std::string& error) const override {
    return hypgen::cuda::walk_on_device<M>(params_.get(), range, warps, 0, out, error);
  }

 private:
  std::unique_ptr<typename M::Params> params_ = std::make_unique<typename M::Params>();
};

struct Entry {
  std::string name;
  int most_warps;
  hypgen::ParamValues params;
  std::unique_ptr<Walks> (*make)(const hypgen::ParamValues& values, std::string& error);
};

template <class M>
Entry entry(const char* name, const hypgen::ParamValues& params) {
  return {name, M::kMaxWarps, params, &TypedWalks<M>::make};
}

// All models of the program, in the order of their seeds; written by the generator.
std::vector<Entry> entries();

}  // namespace random_walks
