// SPDX-License-Identifier: Apache-2.0
// The scenarios of a search walked again after it: what each group of a tree has seen.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hypgen/leaves/grouping.hpp"
#include "hypgen/memory/scenario_buffer.hpp"
#include "hypgen/model/key.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

// The rows of an evaluator name a group by its first scenario and keep no observation. A scenario's future is a
// function of its number, so that a second walk meets the same groups. The walk begins at the root.
class ScenarioWalk {
 public:
  struct Group {
    std::uint32_t first = 0;  // its first scenario: a position among those of the node, as in a ChildRow
    std::uint32_t count = 0;  // of its scenarios
    bool is_terminal = false;
    std::vector<std::uint64_t> key{};  // what they see
  };

  virtual ~ScenarioWalk() = default;
  virtual std::size_t size() const = 0;  // scenarios at the node
  // The groups below an action that is legal at the node, by `first`.
  virtual std::vector<Group> groups(int action) = 0;
  // Goes on to a group that is not terminal, and back.
  virtual void enter(int action, std::uint32_t first) = 0;
  virtual void leave() = 0;
};

template <class M>
class ModelWalk final : public ScenarioWalk {
 public:
  // `key` is that of the search whose root has these scenarios. All arguments outlive the walk.
  ModelWalk(const typename M::Params& params, const ScenarioBuffer& root, StreamKey key)
      : params_(params), first_(root.first()), key_(key), fixed_(root.size()), nodes_(1) {
    std::vector<typename M::State> states(root.size());
    root.copy_to(fixed_.data(), states.data());
    for (std::uint32_t i = 0; i < states.size(); ++i) nodes_[0].push_back({i, states[i]});
  }

  std::size_t size() const override { return nodes_.back().size(); }

  std::vector<Group> groups(int action) override {
    std::vector<Group> found;
    ActionGrouping<typename M::Key> grouping(size());
    grouping.clear();
    for (std::uint32_t i = 0; i < size(); ++i) {
      const Successor next = successor(nodes_.back()[i], action);
      const std::uint32_t number = grouping.number(next.is_terminal, next.key);
      if (number == found.size()) {
        const KeyWords words = words_of(next.key);
        found.push_back({i, 0, next.is_terminal, {words.begin(), words.end()}});
      }
      ++found[number].count;
    }
    return found;
  }

  void enter(int action, std::uint32_t first) override {
    const std::vector<Member>& members = nodes_.back();
    const typename M::Key wanted = successor(members[first], action).key;
    std::vector<Member> group;
    for (std::size_t i = first; i < members.size(); ++i) {
      const Successor next = successor(members[i], action);
      if (!next.is_terminal && next.key == wanted) group.push_back({members[i].scenario, next.state});
    }
    nodes_.push_back(std::move(group));
  }

  void leave() override { nodes_.pop_back(); }

 private:
  struct Member {
    std::uint32_t scenario;
    typename M::State state;
  };
  struct Successor {
    typename M::State state;
    typename M::Key key;
    bool is_terminal;
  };

  Successor successor(const Member& member, int action) const {
    const typename M::Fixed& fixed = fixed_[member.scenario];
    PhiloxDraws draws(key_, first_ + member.scenario, static_cast<std::uint32_t>(nodes_.size()) - 1);
    Successor next{{}, {}, false};
    next.is_terminal = M::step(params_, fixed, member.state, action, draws, next.state).terminal;
    if (!next.is_terminal) next.key = M::observe(params_, fixed, member.state, action, draws, next.state);
    return next;
  }

  const typename M::Params& params_;
  std::uint32_t first_;
  StreamKey key_;
  std::vector<typename M::Fixed> fixed_;
  std::vector<std::vector<Member>> nodes_;  // from the root to where the walk is
};

}  // namespace hypgen
