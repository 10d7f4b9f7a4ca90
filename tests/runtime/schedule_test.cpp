// SPDX-License-Identifier: Apache-2.0
// Steps that warps share: what the schedule's check accepts, and every mistake that it must see.
#include "hypgen/verify/schedule.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/episode/world.hpp"
#include "hypgen/episode/worlds.hpp"
#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/leaves/scenario_walk.hpp"
#include "hypgen/model/descriptor.hpp"
#include "hypgen/verify/digest_walks.hpp"
#include "hypgen/verify/selftest.hpp"
#include "hypgen/verify/verifiable_model.hpp"
#include "test_models.hpp"

namespace hypgen {
namespace {

enum class Mistake { kNone, kSharedWord, kOrder, kRewrite, kLostMember };

// Four counters, one a word, which the action and draws move; partitioned with a mistake.
template <Mistake kMistake>
struct Counters : NoHistory, NotFactored {
  static constexpr int kActionCount = 3;
  static constexpr bool kHasLower = false;
  static constexpr int kStages = 2;
  static constexpr int kMaxWarps = 4;
  using Key = std::uint64_t;
  struct Params {};
  struct Fixed {
    std::uint32_t words[1];
  };
  struct State {
    std::uint32_t words[5];  // the counters, and their sum modulo 2^16
  };

  template <class D>
  static void init_visible(const Params&, D&, Fixed& fixed, State& state) {
    fixed = {};
    state = {};
  }
  template <class D>
  static void init_hidden(const Params&, D& draws, Fixed&, State& state) {
    for (std::uint32_t i = 0; i < 4; ++i) state.words[i] = draws.word(1, i) >> 24;
  }
  static bool is_legal(const Params&, const Fixed&, const State& state, int action) {
    return action == 0 || state.words[0] % 2 == 0;
  }

  template <class D>
  static void count(const State& state, int action, D& draws, State& next, int i) {
    next.words[i] = state.words[i] + static_cast<std::uint32_t>(action) +
                    (draws.word(2, static_cast<std::uint32_t>(i)) >> 28);
    if (kMistake == Mistake::kOrder && i == 1) next.words[1] += next.words[2];
    if (kMistake == Mistake::kSharedWord && i > 1) next.words[4] ^= 1U << (i + (draws.word(2, 9) >> 30));
    if (kMistake == Mistake::kRewrite && i == 3) next.words[2] &= 0x7FFFFFFF;
  }
  static void add(State& next) {
    next.words[4] = (next.words[0] + next.words[1] + next.words[2] + next.words[3]) & 0xFFFF;
  }
  static std::int64_t earned(const State& next, int i) {
    return math::to_fixed(static_cast<int>(next.words[i]));
  }

  template <class D>
  static StepResult step(const Params& params, const Fixed& fixed, const State& state, int action, D& draws,
                         State& next) {
    next = state;
    for (int i = 0; i < 4; ++i) count(state, action, draws, next, i);
    add(next);
    std::int64_t sum = 0;
    for (int i = 0; i < 4; ++i) sum += earned(next, i);
    return step_end(params, fixed, state, action, draws, next, sum, false);
  }
  template <class D>
  static void step_stage(int stage, const Params&, const Fixed&, const State& state, int action, D& draws,
                         State& next, Part part) {
    if (stage == 0) {
      for (int i = part.first(0); i < 4; i += part.count) count(state, action, draws, next, i);
    }
    if (stage == 1 && part.takes(0)) add(next);
  }
  template <class D>
  static void step_rewards(const Params&, const Fixed&, const State&, int, D&, const State& next, Part part,
                           std::int64_t& sum, bool&) {
    const int members = kMistake == Mistake::kLostMember ? 3 : 4;
    for (int i = part.first(0); i < members; i += part.count) sum += earned(next, i);
  }
  template <class D>
  static StepResult step_end(const Params&, const Fixed&, const State&, int, D&, const State& next,
                             std::int64_t sum, bool error) {
    return {math::saturate_fixed(sum), next.words[4] > 800, false, error};
  }

  template <class D>
  static Key observe(const Params&, const Fixed&, const State&, int, D&, const State& next) {
    return next.words[4] % 5;
  }
  template <class D>
  static double filter(const Params& params, const Fixed& fixed, const State& state, int action, Key key,
                       D& draws, State& next) {
    step(params, fixed, state, action, draws, next);
    return observation_density(params, fixed, state, action, key, draws, next);
  }
  template <class D>
  static double observation_density(const Params&, const Fixed&, const State&, int, Key key, D&,
                                    const State& next) {
    return key == next.words[4] % 5 ? 1.0 : 0.0;
  }
  template <class D>
  static int default_policy(const Params&, const Fixed&, const State&, const History&, D&) {
    return 0;
  }
  static float upper(const Params&, const Fixed&, const State&) { return 1e6F; }
  static float tail(const Params&, const Fixed&, const State&) { return 0.0F; }
};

constexpr DigestRange kRange{{7, 8}, 0, 200, 30};

// Walks, and does nothing else of a model.
template <class M>
class WalkingInstance final : public VerifiableInstance {
 public:
  std::unique_ptr<LeafEvaluator> make_evaluator(const EvaluatorOptions&) const override { return nullptr; }
  std::unique_ptr<LeafEvaluator> add_host(std::unique_ptr<LeafEvaluator>,
                                          const EvaluatorOptions&) const override {
    return nullptr;
  }
  std::unique_ptr<Belief> make_belief(std::uint64_t, std::size_t, BeliefKind) const override {
    return nullptr;
  }
  std::unique_ptr<World> make_world(std::uint64_t) const override { return nullptr; }
  std::unique_ptr<Worlds> make_worlds(std::uint64_t, std::size_t, std::vector<KeyDigit>) const override {
    return nullptr;
  }
  void export_states(const ScenarioBuffer&, std::int32_t*) const override {}
  std::unique_ptr<ScenarioWalk> walk(const ScenarioBuffer&, StreamKey, bool) const override {
    return nullptr;
  }
  bool write_trace(const TraceOptions&, std::string&) const override { return false; }
  ScheduleFault digests(const DigestRange& range, int warps, std::uint64_t* out) const override {
    return walk_lanes<M>(params_, range, warps, out);
  }
  BoundsFound check_bounds(const BoundsWalk&) const override { return {}; }
  const void* params() const override { return &params_; }

 private:
  typename M::Params params_{};
};

template <class M>
ScheduleFault fault_of(int warps) {
  std::vector<std::uint64_t> digests(kRange.lanes);
  return WalkingInstance<M>().digests(kRange, warps, digests.data());
}

template <class M>
WalkComparison difference(int warps) {
  const WalkingInstance<M> instance;
  const auto walker = [&](int w) -> Walker {
    return [&instance, w](const DigestRange& range, std::uint64_t* digests, std::string&) {
      instance.digests(range, w, digests);
      return true;
    };
  };
  std::vector<std::uint64_t> plain(kRange.lanes), found(kRange.lanes);
  instance.digests(kRange, 1, plain.data());
  instance.digests(kRange, warps, found.data());
  WalkComparison comparison;
  std::string error;
  EXPECT_TRUE(compare_walks(kRange, plain, found, walker(1), walker(warps), comparison, error));
  return comparison;
}

TEST(Part, DealsInTurn) {
  for (int count = 1; count <= 5; ++count) {
    for (int number = 0; number < 12; ++number) {
      int takers = 0;
      for (int rank = 0; rank < count; ++rank) {
        const Part part{rank, count};
        takers += part.takes(number) ? 1 : 0;
        EXPECT_TRUE(part.takes(number + part.first(number)));
        EXPECT_LT(part.first(number), count);
      }
      EXPECT_EQ(takers, 1);
    }
  }
}

TEST(Schedule, FindsNothingInACorrectPartition) {
  for (int warps = 1; warps <= kMostWarps; ++warps) {
    EXPECT_EQ(fault_of<Counters<Mistake::kNone>>(warps).kind, ScheduleFault::Kind::kNone);
    EXPECT_EQ(difference<Counters<Mistake::kNone>>(warps).differing, 0U);
  }
}

TEST(Schedule, SeesTwoWarpsWriteOneWord) {
  const ScheduleFault fault = fault_of<Counters<Mistake::kSharedWord>>(2);
  EXPECT_EQ(fault.kind, ScheduleFault::Kind::kSharedWord);
  EXPECT_EQ(fault.word, 4);
  EXPECT_EQ(fault.stage, 0);
}

TEST(Schedule, SeesThatTheOrderMatters) {
  const ScheduleFault fault = fault_of<Counters<Mistake::kOrder>>(4);
  EXPECT_TRUE(fault.kind == ScheduleFault::Kind::kOrder || fault.kind == ScheduleFault::Kind::kDependence);
  EXPECT_EQ(fault.word, 1);
}

// No order shows it where the value stays the same, but a real warp would undo its neighbour's write.
TEST(Schedule, SeesAWordThatIsWrittenBackUnchanged) {
  const ScheduleFault fault = fault_of<Counters<Mistake::kRewrite>>(2);
  EXPECT_EQ(fault.kind, ScheduleFault::Kind::kDependence);
  EXPECT_EQ(fault.word, 2);
  EXPECT_EQ(fault.warp, 1);
}

TEST(Schedule, FaultsNeedSeveralWarps) {
  EXPECT_EQ(fault_of<Counters<Mistake::kOrder>>(1).kind, ScheduleFault::Kind::kNone);
}

TEST(Walks, NameTheFirstStepThatDiffers) {
  EXPECT_EQ(fault_of<Counters<Mistake::kLostMember>>(2).kind, ScheduleFault::Kind::kNone);
  const WalkComparison comparison = difference<Counters<Mistake::kLostMember>>(2);
  EXPECT_EQ(comparison.differing, kRange.lanes);
  EXPECT_EQ(comparison.lane, 0U);
  EXPECT_EQ(comparison.step, 0U);
}

TEST(Walks, DependOnNeitherThreadsNorRanges) {
  const WalkingInstance<Counters<Mistake::kNone>> instance;
  ScheduleFault fault{};
  const auto quiet = [](std::uint32_t) {};
  const auto one = walk_on_host(instance, kRange, 1, 1, quiet, fault);
  EXPECT_EQ(walk_on_host(instance, kRange, 1, 5, quiet, fault), one);
  std::uint64_t last = 0;
  instance.digests({kRange.key, 199, 1, kRange.steps}, 1, &last);
  EXPECT_EQ(last, one[199]);
  EXPECT_NE(one[0], one[1]);
}

TEST(Walks, TakeModelsThatSayNothingOfWarps) {
  using Model = testing::RockSample<4, 3>;
  static_assert(!IsPartitioned<Model>::value);
  EXPECT_EQ(difference<Model>(4).differing, 0U);
}

TEST(Selftest, EndsWithOneWhereSomethingDiffers) {
  SelftestOptions options;
  options.lanes = 50;
  options.json_file = "/dev/null";
  options.quiet = true;
  using Good = Counters<Mistake::kNone>;
  using Bad = Counters<Mistake::kLostMember>;
  EXPECT_EQ(selftest(VerifiableModel(), WalkingInstance<Good>(), options), 0);
  EXPECT_EQ(selftest(VerifiableModel(), WalkingInstance<Bad>(), options), 1);
}

}  // namespace
}  // namespace hypgen
