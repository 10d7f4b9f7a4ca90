// SPDX-License-Identifier: Apache-2.0
// Ties a model's type to the exact solver: what a generated exact.cpp includes. Without Eigen, which takes
// a compiler seconds to read.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hypgen/episode/world.hpp"
#include "hypgen/exact/outcome_model.hpp"
#include "hypgen/exact/text_rounding.hpp"
#include "hypgen/model/descriptor.hpp"
#include "hypgen/model/model_contract.hpp"

namespace hypgen::exact {

// A model with its params.
class ExactInstance {
 public:
  virtual ~ExactInstance() = default;
  virtual const OutcomeModel& outcomes() const = 0;
  virtual std::unique_ptr<World> make_world(std::uint64_t seed) const = 0;
};

template <class M>
class TypedExactInstance final : public ExactInstance {
 public:
  explicit TypedExactInstance(std::unique_ptr<typename M::Params> params)
      : params_(std::move(params)), outcomes_(*params_) {}

  const OutcomeModel& outcomes() const override { return outcomes_; }

  std::unique_ptr<World> make_world(std::uint64_t seed) const override {
    return std::make_unique<ModelWorld<M>>(*params_, seed);
  }

 private:
  std::unique_ptr<typename M::Params> params_;
  TypedOutcomeModel<M> outcomes_;
};

// A model as the exact solver sees it. `descriptor.create` is not used.
struct ExactDescriptor {
  ModelDescriptor descriptor;
  // The values of all flattened variables as people read them.
  std::function<std::vector<std::string>(const std::int32_t*)> value_names;
  std::function<std::unique_ptr<ExactInstance>(const ParamValues&, std::string& error)> create;
  TextRounding rounding;    // with the params of the text ...
  TextRounding any_params;  // ... and with any that their types allow
};

// Loads the params; null and `error` if the model rejects them.
template <class M>
std::unique_ptr<ExactInstance> make_exact_instance(const ParamValues& values, std::string& error) {
  static_assert(ModelContract<M>::kHolds);
  auto params = std::make_unique<typename M::Params>();
  if (!M::load(values, *params, error)) return nullptr;
  return std::make_unique<TypedExactInstance<M>>(std::move(params));
}

}  // namespace hypgen::exact
