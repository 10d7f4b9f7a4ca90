// SPDX-License-Identifier: Apache-2.0
// A GPU for tests on machines without one.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hypgen/episode/worlds.hpp"
#include "hypgen/leaves/cpu_evaluator.hpp"
#include "hypgen/leaves/device.hpp"
#include "mock_evaluator.hpp"
#include "test_models.hpp"

namespace hypgen::testing {

// Worlds whose GPU fails once a world's action is `kBreaks`.
class FakeWorlds final : public Worlds {
 public:
  static constexpr std::int32_t kBreaks = 99;

  FakeWorlds(const RockSample<4, 3>::Params& params, std::uint64_t seed, std::size_t count,
             std::vector<KeyDigit> digits)
      : inner_(params, seed, count, std::move(digits)), count_(count) {}

  Status reseed(std::uint64_t seed, std::string& error) override {
    return works(error) ? inner_.reseed(seed, error) : Status::kNoGpu;
  }
  Status set_start(StartValues start, std::string& error) override {
    return works(error) ? inner_.set_start(std::move(start), error) : Status::kNoGpu;
  }
  Status reset(const std::uint8_t* mask, const std::uint64_t* episodes, std::size_t& refused,
               std::string& error) override {
    return works(error) ? inner_.reset(mask, episodes, refused, error) : Status::kNoGpu;
  }
  Status export_visible(std::int32_t* out, std::string& error) override {
    return works(error) ? inner_.export_visible(out, error) : Status::kNoGpu;
  }
  Status export_legal(std::uint8_t* out, std::string& error) override {
    return works(error) ? inner_.export_legal(out, error) : Status::kNoGpu;
  }
  Status step(const std::int32_t* actions, const WorldsResults& out, std::size_t& refused,
              std::string& error) override {
    is_lost_ = is_lost_ || std::find(actions, actions + count_, kBreaks) != actions + count_;
    return works(error) ? inner_.step(actions, out, refused, error) : Status::kNoGpu;
  }

 private:
  bool works(std::string& error) const {
    if (is_lost_) error = "GPU: lost";
    return !is_lost_;
  }

  ModelWorlds<RockSample<4, 3>> inner_;
  std::size_t count_;
  bool is_lost_ = false;
};

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
    auto inner = std::make_unique<CpuEvaluator<Model>>(*static_cast<const Model::Params*>(params), options);
    return std::make_unique<MockEvaluator>(std::move(inner), mischief_);
  }
  std::unique_ptr<Worlds> make_worlds(const void* params, std::uint64_t seed, std::size_t count,
                                      const std::vector<KeyDigit>& digits, int,
                                      std::string& error) const override {
    if (count > kMostWorlds) {
      error = std::to_string(count) + " worlds need more memory than there is";
      return nullptr;
    }
    return std::make_unique<FakeWorlds>(*static_cast<const Model::Params*>(params), seed, count, digits);
  }

 private:
  using Model = RockSample<4, 3>;
  static constexpr std::size_t kMostWorlds = 100;

  bool works_;
  Mischief mischief_;
};

}  // namespace hypgen::testing
