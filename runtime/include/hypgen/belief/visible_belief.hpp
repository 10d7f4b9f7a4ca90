// SPDX-License-Identifier: Apache-2.0
// A belief that knows what the agent sees and remembers, and nothing of hidden variables: all that a default
// policy reads.
#pragma once

#include <cstdint>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen {

// It moves one state as a particle filter would. Visible variables do not depend on its hidden ones, as the
// filter takes them from what was seen.
template <class M>
class VisibleBelief final : public Belief {
 public:
  VisibleBelief(const typename M::Params& params, std::uint64_t seed) : params_(params), seed_(seed) {}

  bool knows_hidden() const override { return false; }

  Status init(const std::int32_t* visible, std::uint64_t run) override {
    key_ = derive(seed_, StreamKind::kBelief, run);
    step_ = 0;
    M::import_visible(visible, fixed_, state_);
    PhiloxDraws draws(key_, 0, 0);
    M::init_hidden(params_, draws, fixed_, state_);
    M::init_history(params_, fixed_, state_, history_);
    return Status::kOk;
  }

  Status update(int action, KeyWords words) override {
    const auto key = key_from<typename M::Key>(words);
    PhiloxDraws draws(key_, 0, ++step_);
    typename M::State next;
    M::filter(params_, fixed_, state_, action, key, draws, next);
    typename M::History after;
    M::advance_history(params_, fixed_, state_, action, key, next, history_, after);
    history_ = after;
    state_ = next;
    return Status::kOk;
  }

  void propagate(int action, KeyWords words) override { update(action, words); }

  void reserve(ScenarioBuffer& buffer, std::size_t capacity) const override {
    buffer.reserve(sizeof(typename M::Fixed), sizeof(typename M::State), sizeof(typename M::History),
                   capacity);
  }

  void sample(StreamKey, std::uint32_t first, std::size_t count, ScenarioBuffer& out) const override {
    out.clear(first);
    out.set_history(history_);
    for (std::size_t i = 0; i < count; ++i) out.push(fixed_, state_);
  }

  bool is_legal(int action) const override { return M::is_legal(params_, fixed_, state_, action); }

  int default_action(StreamKey key) const override {
    PhiloxDraws draws(key, 0, 0);
    return M::default_policy(params_, fixed_, state_, history_, draws);
  }

  void each_value(int variable, const TakeValue& take) const override {
    std::int32_t values[M::kVariableCount];
    M::export_state(fixed_, state_, values);
    take(values[variable], 1.0);
  }

  void export_particles(ScenarioBuffer& particles, std::vector<double>& weights) const override {
    sample({}, 0, 1, particles);
    weights.assign(1, 1.0);
  }
  bool import_particles(const ScenarioBuffer&, const std::vector<double>&) override { return false; }

  double effective_sample_size() const override { return 1.0; }
  std::size_t size() const override { return 1; }

 private:
  const typename M::Params& params_;
  std::uint64_t seed_;
  StreamKey key_{};
  std::uint32_t step_ = 0;
  typename M::Fixed fixed_{};
  typename M::State state_{};
  typename M::History history_{};
};

}  // namespace hypgen
