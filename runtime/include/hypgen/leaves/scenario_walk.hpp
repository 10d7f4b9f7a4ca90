// SPDX-License-Identifier: Apache-2.0
// The scenarios of a search walked again after it: what each group of a tree has seen.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "hypgen/leaves/weighted_parts.hpp"
#include "hypgen/memory/scenario_buffer.hpp"
#include "hypgen/model/key.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

// The rows of an evaluator name a group by its first member, a place among those of the node, and keep no observation.
// A scenario's future is a function of its number, so that a second walk meets the same groups. The walk begins at the
// root.
class ScenarioWalk {
 public:
  struct Seen {
    bool is_terminal = false;
    std::vector<std::uint64_t> key{};  // nothing after the end
  };

  virtual ~ScenarioWalk() = default;
  // What the group sees after an action that is legal at the node.
  virtual Seen seen(int action, std::uint32_t first) = 0;
  // Goes on to a group that is not terminal, of that count or mass, and back.
  virtual void enter(int action, std::uint32_t first, std::uint32_t count) = 0;
  virtual void leave() = 0;
};

template <class M>
class ModelWalk final : public ScenarioWalk {
 public:
  // `key` is that of the search whose root has these scenarios. `weighted`: its groups share them. All arguments outlive
  // the walk.
  ModelWalk(const typename M::Params& params, const ScenarioBuffer& root, StreamKey key, bool weighted)
      : work_{params, root.first(), key, std::vector<typename M::Fixed>(root.size())}, nodes_(1) {
    std::vector<typename M::State> states(root.size());
    root.copy_to(work_.all_fixed.data(), states.data());
    for (std::uint32_t i = 0; i < states.size(); ++i) nodes_[0].push_back({i, states[i]});
    if (weighted) parts_ = std::make_unique<WeightedParts<M>>(root.capacity());
  }

  Seen seen(int action, std::uint32_t first) override {
    const Successor next = successor(first, action);
    if (next.is_terminal) return {true};
    const KeyWords words = words_of(next.key);
    return {false, {words.begin(), words.end()}};
  }

  void enter(int action, std::uint32_t first, std::uint32_t count) override {
    nodes_.push_back(parts_ ? drawn(action, first, count) : like(action, first));
  }

  void leave() override { nodes_.pop_back(); }

  // Of the node where the walk is.
  const std::vector<CpuMember<M>>& members() const { return nodes_.back(); }

 private:
  using Members = std::vector<CpuMember<M>>;

  struct Successor {
    typename M::State state;
    typename M::Key key;
    bool is_terminal;
  };

  // What simulates the model, as long as it takes.
  struct Work {
    struct Endless {
      bool add(std::size_t) { return false; }
    };
    const typename M::Params& params;
    std::uint32_t first;
    StreamKey key;
    std::vector<typename M::Fixed> all_fixed;
    Endless clock{};

    const typename M::Fixed& fixed(const CpuMember<M>& member) const { return all_fixed[member.scenario]; }
    PhiloxDraws draws(std::uint32_t number, int depth) const {
      return PhiloxDraws(key, first + number, static_cast<std::uint32_t>(depth));
    }
  };

  int depth() const { return static_cast<int>(nodes_.size()) - 1; }

  Successor successor(std::size_t i, int action) const {
    const CpuMember<M>& member = nodes_.back()[i];
    const typename M::Fixed& fixed = work_.fixed(member);
    PhiloxDraws draws = work_.draws(parts_ ? static_cast<std::uint32_t>(i) : member.scenario, depth());
    Successor next{{}, {}, false};
    next.is_terminal = M::step(work_.params, fixed, member.state, action, draws, next.state).terminal;
    if (!next.is_terminal)
      next.key = M::observe(work_.params, fixed, member.state, action, draws, next.state);
    return next;
  }

  // The members that see what member `first` sees.
  Members like(int action, std::uint32_t first) const {
    const typename M::Key wanted = successor(first, action).key;
    Members group;
    for (std::size_t i = first; i < nodes_.back().size(); ++i) {
      const Successor next = successor(i, action);
      if (!next.is_terminal && next.key == wanted) group.push_back({nodes_.back()[i].scenario, next.state});
    }
    return group;
  }

  // The members that a group of shares draws.
  Members drawn(int action, std::uint32_t first, std::uint32_t mass) {
    const Members& from = nodes_.back();
    std::vector<bool> ended(from.size());
    parts_->step(work_, action, from.data(), from.size(), depth(),
                 [&](std::size_t i, const StepResult& result) { ended[i] = result.terminal; });
    parts_->part(work_, action, from.data(), from.size(), depth(), [&](std::size_t i) { return ended[i]; });
    const WeightedGroups<M>& groups = parts_->groups();
    const std::uint32_t group = groups.named(first);
    Members members(parts_->most());
    if (group != groups.count())
      members.resize(
          parts_->draw(group, mass, work_.key, action, depth(), from.data(), from.size(), members.data()));
    return members;
  }

  Work work_;
  std::unique_ptr<WeightedParts<M>> parts_;  // null: scenarios that see the same stay together
  std::vector<Members> nodes_;               // from the root to where the walk is
};

}  // namespace hypgen
