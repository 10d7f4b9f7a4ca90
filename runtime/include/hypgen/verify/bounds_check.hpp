// SPDX-License-Identifier: Apache-2.0
// Samples a model's bounds.
//
// At beliefs met along episodes, what the default policy earns from there is compared with the bounds there:
// the mean over particles may not be above `upper`, nor below `lower` or `tail`, by five standard errors. A
// bound that fails is looked at again with many more particles, as the errors of few are rough.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/episode/world.hpp"
#include "hypgen/leaves/rollout_step.hpp"
#include "hypgen/memory/scenario_buffer.hpp"
#include "hypgen/model/descriptor.hpp"
#include "hypgen/model/model.hpp"
#include "hypgen/random/philox.hpp"
#include "hypgen/verify/bound_sums.hpp"
#include "hypgen/verify/verifiable_model.hpp"

namespace hypgen {

struct BoundsCheckOptions {
  std::uint64_t beliefs = 0;  // 0: no check
  int steps = 90;             // most of an episode
  std::size_t threads = 1;
  std::uint64_t seed = 0;
  std::string json_file;  // empty: a table
};

// A walk of so many beliefs, which depends on nothing but these.
struct BoundsWalk {
  std::uint64_t seed = 0;
  std::uint32_t number = 0;
  std::uint64_t beliefs = 0;
  int steps = 0;  // most of an episode
  int horizon = 0;
  double discount = 1.0;
};

// Checks the bounds of all models that have one: prints what was compared; gives 0 if no bound is violated, 1
// if one is or if the result could not be written.
int check_bounds(const ModelDescriptor& model, const VerifiableInstance& instance,
                 const BoundsCheckOptions& options);

// Walks and compares.
template <class M>
class BoundsChecker {
 public:
  static constexpr std::size_t kParticles = 200;  // of the belief
  static constexpr std::size_t kFew = 16;         // of a comparison
  static constexpr std::size_t kMany = 2048;      // of the second look
  static constexpr std::size_t kSome = 256;       // of a look at another policy

  BoundsChecker(const typename M::Params& params, const BoundsWalk& walk, Belief& belief)
      : params_(params),
        walk_(walk),
        belief_(belief),
        key_(derive(walk.seed, StreamKind::kTest, kFirstStream + walk.number)),
        fixed_(kMany),
        states_(kMany) {
    belief_.reserve(buffer_, kMany);
    for (double power = 1.0; power > kNegligible && discounts_.size() < kLongest; power *= walk.discount) {
      discounts_.push_back(static_cast<float>(power));
    }
  }

  BoundsFound run() {
    ModelWorld<M> world(params_, walk_.seed);
    std::vector<std::int32_t> visible(M::kVisibleCount + 1);
    for (std::uint64_t run = std::uint64_t{walk_.number} << 16; met_ < walk_.beliefs; ++run) {
      world.reset(run);
      world.export_visible(visible.data());
      belief_.init(visible.data(), run);
      for (int t = 0; t < walk_.steps && met_ < walk_.beliefs; ++t) {
        compare(t);
        const int action = choose(world);
        ++met_;
        if (action < 0) break;
        const WorldStep step = world.step(action);
        if (step.result.terminal || belief_.update(action, step.key) != Status::kOk) break;
      }
    }
    return found_;
  }

 private:
  static constexpr std::uint64_t kFirstStream = 16;  // traces take the first ones
  static constexpr std::uint32_t kSampleSite = 0xB0D1, kWhetherSite = 0xB0D2, kActionSite = 0xB0D3;
  static constexpr double kNegligible = 1e-6;  // of a reward
  static constexpr std::size_t kLongest = 20000;
  static constexpr int kDefault = -1;      // the default policy's action
  static constexpr int kMostActions = 64;  // that are tried as policies
  static constexpr double kSigmas = 5.0;
  static constexpr double kRounding = 1e-4;  // of a value: float sums, and what comes after the last step

  struct Sums {
    double room = 0.0;
    double squares = 0.0;
    double largest = 0.0;

    void add(double value, double bound) {
      room += value;
      squares += value * value;
      largest = std::max(largest, std::abs(bound));
    }
    double mean(std::size_t count) const { return room / static_cast<double>(count); }
    // Not so for a NaN either.
    bool holds(std::size_t count) const {
      const auto n = static_cast<double>(count);
      const double variance = std::max(0.0, squares - room * room / n) / (n - 1.0);
      return mean(count) >=
             -kSigmas * std::sqrt(variance / n) - kRounding * std::max(reward_scale(kRewardBits<M>), largest);
    }
  };

  // Compares all bounds at the present belief, which has seen `t` steps.
  void compare(int t) {
    const std::array<Sums, kBounds> sums = look(t, kFew, 0, kDefault);
    std::array<Sums, kBounds> again{};
    bool looked = false;
    for (std::size_t i = 0; i < kBounds; ++i) {
      if (!has(static_cast<Bound>(i))) continue;
      ++found_[i].compared;
      found_[i].room += sums[i].mean(kFew);
      if (sums[i].holds(kFew)) continue;
      if (!looked) again = look(t, kMany, kFew, kDefault);
      looked = true;
      found_[i].violations += again[i].holds(kMany) || is_earned(t, static_cast<Bound>(i)) ? 0 : 1;
    }
  }

  // Whether doing one thing for ever earns a lower bound that the default policy does not.
  bool is_earned(int t, Bound bound) {
    if (bound == Bound::kUpper || bound == Bound::kDeclared) return false;
    for (int action = 0; action < std::min(M::kActionCount, kMostActions); ++action) {
      if (look(t, kSome, kFew + kMany, action)[static_cast<std::size_t>(bound)].holds(kSome)) return true;
    }
    return false;
  }

  static constexpr bool has(Bound bound) {
    return bound == Bound::kDeclared ? IsRelaxed<M>::value : bound != Bound::kLower || M::kHasLower;
  }

  // What `count` particles tell, which draw under numbers from `first` on, if `always` is done where it is
  // legal.
  std::array<Sums, kBounds> look(int t, std::size_t count, std::size_t first, int always) {
    PhiloxDraws draws(key_, static_cast<std::uint32_t>(met_), 0);
    const StreamKey own{draws.word(kSampleSite, 0), draws.word(kSampleSite, 1)};
    belief_.sample(own, static_cast<std::uint32_t>(first), count, buffer_);
    buffer_.copy_to(fixed_.data(), states_.data());
    typename M::History history;
    buffer_.copy_history_to(history);
    std::array<Sums, kBounds> sums{};
    const auto add = [&](Bound bound, double room, double value) {
      sums[static_cast<std::size_t>(bound)].add(room, value);
    };
    for (std::size_t i = 0; i < count; ++i) {
      const double earned =
          play(own, static_cast<std::uint32_t>(first + i), t, always, fixed_[i], states_[i], history);
      const double upper = M::upper(params_, fixed_[i], states_[i]);
      add(Bound::kUpper, upper - earned, upper);
      if constexpr (IsRelaxed<M>::value) {
        const double declared = M::declared_upper(params_, fixed_[i], states_[i]);
        add(Bound::kDeclared, declared - earned, declared);
      }
      if constexpr (M::kHasLower) {
        const double lower = M::lower(params_, fixed_[i], states_[i], history);
        add(Bound::kLower, earned - lower, lower);
      }
      const double tail = M::tail(params_, fixed_[i], states_[i]);
      add(Bound::kTail, earned - tail, tail);
    }
    return sums;
  }

  // What is earned from here on; NaN if a reward is.
  double play(StreamKey key, std::uint32_t scenario, int t, int always, const typename M::Fixed& fixed,
              typename M::State state, typename M::History history) const {
    float total = 0.0F;
    bool nan = false;
    const std::size_t left =
        walk_.horizon > 0 ? static_cast<std::size_t>(std::max(0, walk_.horizon - t)) : discounts_.size();
    for (std::size_t i = 0; i < std::min(left, discounts_.size()); ++i) {
      PhiloxDraws draws(key, scenario, static_cast<std::uint32_t>(i + 1));
      const bool is_usual = always == kDefault || !M::is_legal(params_, fixed, state, always);
      const int action = is_usual ? M::default_policy(params_, fixed, state, history, draws) : always;
      if (action < 0) break;
      typename M::State next;
      const StepResult result = M::step(params_, fixed, state, action, draws, next);
      if (!take_in<M>(result, params_, fixed, action, draws, next, discounts_[i], state, history, total, nan))
        break;
    }
    return nan ? std::nan("") : static_cast<double>(total);
  }

  // What is done next: one step of four any legal action, otherwise the default policy's; -1 if none is
  // legal.
  int choose(const World& world) const {
    PhiloxDraws draws(key_, static_cast<std::uint32_t>(met_), 1);
    if (draws.word(kWhetherSite, 0) >> 30 != 0) {
      return belief_.default_action({draws.word(kActionSite, 1), draws.word(kActionSite, 2)});
    }
    std::vector<int> legal;
    for (int action = 0; action < M::kActionCount; ++action) {
      if (world.is_legal(action)) legal.push_back(action);
    }
    if (legal.empty()) return -1;
    return legal[(std::uint64_t{draws.word(kActionSite, 0)} * legal.size()) >> 32];
  }

  const typename M::Params& params_;
  BoundsWalk walk_;
  Belief& belief_;
  StreamKey key_;
  std::vector<float> discounts_;  // of the steps of a rollout
  std::uint64_t met_ = 0;         // beliefs
  BoundsFound found_{};
  ScenarioBuffer buffer_;
  std::vector<typename M::Fixed> fixed_;
  std::vector<typename M::State> states_;
};

}  // namespace hypgen
