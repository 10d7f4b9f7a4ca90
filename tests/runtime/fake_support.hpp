// SPDX-License-Identifier: Apache-2.0
// A GPU for tests on machines without one.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hypgen/leaves/cpu_evaluator.hpp"
#include "hypgen/leaves/device.hpp"
#include "mock_evaluator.hpp"
#include "test_models.hpp"

namespace hypgen::testing {

// A GPU that the CPU stands in for, if there is one.
class FakeSupport final : public DeviceSupport {
 public:
  explicit FakeSupport(bool works, const Mischief& mischief = {}) : works_(works), mischief_(mischief) {}

  std::vector<DeviceInfo> devices(std::string& error) const override {
    if (works_) return {{3, "fake", 9, 0, 1, 1}};
    error = "no GPU";
    return {};
  }
  std::unique_ptr<LeafEvaluator> make_evaluator(const void* params, const EvaluatorOptions& options, int,
                                                std::string&) const override {
    using Model = RockSample<4, 3>;
    auto inner = std::make_unique<CpuEvaluator<Model>>(*static_cast<const Model::Params*>(params), options);
    return std::make_unique<MockEvaluator>(std::move(inner), mischief_);
  }

 private:
  bool works_;
  Mischief mischief_;
};

}  // namespace hypgen::testing
