// SPDX-License-Identifier: Apache-2.0
// A step done as the warps of a block do it, one warp after the other on the host: the check that nothing
// depends on their order, where there is no GPU to race on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "hypgen/model/model.hpp"
#include "hypgen/model/part.hpp"
#include "hypgen/random/philox.hpp"
#include "hypgen/verify/digest.hpp"

namespace hypgen {

// What a schedule did that warps must not do to each other within a stage.
struct ScheduleFault {
  enum class Kind {
    kNone,
    kSharedWord,  // two warps wrote one word of the state: a write may be lost
    kOrder,       // another order of the warps gave another state
    kDependence,  // a warp read or wrote what another one writes
  };
  Kind kind = Kind::kNone;
  std::uint32_t lane = 0;
  std::uint32_t step = 0;
  int stage = 0;
  int word = 0;  // of the state
  int warp = 0;
  int warps = 0;
};

// Whether a model says how warps share its steps. Those that the compiler wrote do.
template <class M, class = void>
struct IsPartitioned : std::false_type {};
template <class M>
struct IsPartitioned<M, std::void_t<decltype(M::kStages)>> : std::true_type {};

// A stepper of `digest_lane`: M::step with one warp, otherwise its parts. Each stage is run with the warps in
// two shuffled orders, and each warp once more with garbage in all that the others write.
template <class M>
class ScheduledStepper {
 public:
  using State = typename M::State;

  ScheduledStepper(int warps, StreamKey key, std::uint32_t lane) : warps_(warps), key_(key), lane_(lane) {
    fault_.lane = lane;
    fault_.warps = warps;
  }

  StepResult operator()(const typename M::Params& params, const typename M::Fixed& fixed, const State& state,
                        int action, PhiloxDraws& draws, State& next, bool /*active*/) {
    ++step_;
    if constexpr (IsPartitioned<M>::value) {
      if (warps_ > 1) return Partitioned{*this, params, fixed, state, action, draws, next}.step();
    }
    return M::step(params, fixed, state, action, draws, next);
  }

  // The first fault of the lane.
  const ScheduleFault& fault() const { return fault_; }

 private:
  static constexpr std::size_t kWords = sizeof(State) / sizeof(std::uint32_t);
  static constexpr int kNobody = -1;

  struct Order {
    int ranks[kMostWarps];
  };

  // One step, by its parts.
  struct Partitioned {
    ScheduledStepper& owner;
    const typename M::Params& params;
    const typename M::Fixed& fixed;
    const State& state;
    int action;
    const PhiloxDraws& draws;
    State& next;

    StepResult step() {
      next = state;
      for (int stage = 0; stage < M::kStages; ++stage) run_stage(stage);
      std::int64_t sum = 0;
      bool error = false;
      const Order order = owner.shuffled(M::kStages, 0);
      for (int i = 0; i < owner.warps_; ++i) {
        PhiloxDraws own = draws;
        M::step_rewards(params, fixed, state, action, own, next, Part{order.ranks[i], owner.warps_}, sum,
                        error);
      }
      PhiloxDraws own = draws;
      return M::step_end(params, fixed, state, action, own, next, sum, error);
    }

    void run_warp(int stage, int rank, State& target) const {
      PhiloxDraws own = draws;
      M::step_stage(stage, params, fixed, state, action, own, target, Part{rank, owner.warps_});
    }

    void run_stage(int stage) {
      const State start = next;
      int writers[kWords];
      for (int& writer : writers) writer = kNobody;
      const Order order = owner.shuffled(stage, 0), another = owner.shuffled(stage, 1);
      for (int i = 0; i < owner.warps_; ++i) {
        const State before = next;
        run_warp(stage, order.ranks[i], next);
        note_writers(stage, order.ranks[i], before, writers);
      }
      State again = start;
      for (int i = 0; i < owner.warps_; ++i) run_warp(stage, another.ranks[i], again);
      for (std::size_t w = 0; w < kWords; ++w) {
        if (!equal(again.words[w], next.words[w]))
          owner.note(ScheduleFault::Kind::kOrder, stage, w, writers[w]);
      }
      for (int rank = 0; rank < owner.warps_; ++rank) run_among_garbage(stage, rank, start, writers);
    }

    // As in a digest: which bits a NaN has depends on the order in which the compiler adds its operands, each
    // time that it inlines a stage.
    static bool equal(std::uint32_t one, std::uint32_t other) {
      return math::canonical_bits(math::from_bits(one)) == math::canonical_bits(math::from_bits(other));
    }

    void note_writers(int stage, int rank, const State& before, int* writers) const {
      for (std::size_t w = 0; w < kWords; ++w) {
        if (next.words[w] == before.words[w]) continue;
        if (writers[w] != kNobody) owner.note(ScheduleFault::Kind::kSharedWord, stage, w, rank);
        writers[w] = rank;
      }
    }

    // Every bit of the words that other warps changed is the wrong one: what the warp reads of them shows in
    // its own words, and what it writes shows in theirs.
    void run_among_garbage(int stage, int rank, const State& start, const int* writers) const {
      if (owner.fault_.kind != ScheduleFault::Kind::kNone) return;  // a wrong read might leave an array
      const auto expected = [&](std::size_t w) {
        if (writers[w] == rank) return next.words[w];
        return writers[w] == kNobody ? start.words[w] : ~start.words[w];
      };
      State mine = start;
      for (std::size_t w = 0; w < kWords; ++w) {
        if (writers[w] != rank) mine.words[w] = expected(w);
      }
      run_warp(stage, rank, mine);
      for (std::size_t w = 0; w < kWords; ++w) {
        // What the warp computes may be a NaN; what others write it has to leave as it is.
        const bool is_others = writers[w] != rank && writers[w] != kNobody;
        const bool same = is_others ? mine.words[w] == expected(w) : equal(mine.words[w], expected(w));
        if (!same) owner.note(ScheduleFault::Kind::kDependence, stage, w, rank);
      }
    }
  };

  // The ranks in an order of its own for each step, stage and `turn`.
  Order shuffled(int stage, std::size_t turn) const {
    const PhiloxBlock block =
        philox(key_.key0, key_.key1, {{lane_, step_, static_cast<std::uint32_t>(stage), 0x73636864}});
    std::uint64_t bits = std::uint64_t{block.words[2 * turn]} << 32 | block.words[2 * turn + 1];
    Order order{};
    for (int i = 0; i < warps_; ++i) order.ranks[i] = i;
    for (int i = warps_ - 1; i > 0; --i) {
      const auto choices = static_cast<std::uint64_t>(i) + 1;
      std::swap(order.ranks[i], order.ranks[bits % choices]);
      bits /= choices;
    }
    return order;
  }

  void note(ScheduleFault::Kind kind, int stage, std::size_t word, int warp) {
    if (fault_.kind != ScheduleFault::Kind::kNone) return;
    fault_.kind = kind;
    fault_.step = step_ - 1;
    fault_.stage = stage;
    fault_.word = static_cast<int>(word);
    fault_.warp = warp;
  }

  int warps_;
  StreamKey key_;
  std::uint32_t lane_;
  std::uint32_t step_ = 0;
  ScheduleFault fault_;
};

// Writes a digest for each lane of a range, with several warps of steps in parts; gives the first fault.
template <class M>
ScheduleFault walk_lanes(const typename M::Params& params, const DigestRange& range, int warps,
                         std::uint64_t* digests) {
  ScheduleFault first{};
  for (std::uint32_t i = 0; i < range.lanes; ++i) {
    const std::uint32_t lane = range.first_lane + i;
    ScheduledStepper<M> stepper(warps, range.key, lane);
    digests[i] = digest_lane<M>(params, range.key, lane, range.steps, stepper);
    if (first.kind == ScheduleFault::Kind::kNone) first = stepper.fault();
  }
  return first;
}

}  // namespace hypgen
