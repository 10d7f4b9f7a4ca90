// SPDX-License-Identifier: Apache-2.0
// Random walks through a model with everything that it computes on the way, for differential tests.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "hypgen/core/output.hpp"
#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/model/key.hpp"
#include "hypgen/model/model.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

struct TraceOptions {
  std::string file;
  std::uint64_t seed = 0;
  std::uint32_t scenarios = 64;
  std::uint32_t steps = 64;
};

// Writes int64 rows, step-major: variables and exact posteriors before the step, bits of the likelihood of what
// is seen at the start if the model has one, default policy's action,
// action, reward, terminal, success, words of the key, bits of upper, tail and lower, bits of the density of what
// was seen, bits of the filter's weight, variables of the filter's next state.
template <class M>
class Tracer {
 public:
  Tracer(const typename M::Params& params, const TraceOptions& options)
      : params_(params),
        options_(options),
        key_(derive(options.seed, StreamKind::kTest, 0)),
        filter_key_(derive(options.seed, StreamKind::kTest, 1)),
        lanes_(options.scenarios) {}

  bool write(std::string& error) {
    Output out(options_.file, Output::Kind::kWhole);
    for (std::uint32_t i = 0; i < lanes_.size(); ++i) restart(i, 0);
    for (std::uint32_t t = 0; t < options_.steps && out.ok(); ++t) {
      for (std::uint32_t i = 0; i < lanes_.size(); ++i) {
        row_.clear();
        if (!step(i, t)) restart(i, t + 1);
        write_row(out);
      }
    }
    if (!out.close()) error = out.problem();
    if (!histories_agree_) error = "a bug of hypgen: rollouts keep another history than the agent";
    return error.empty();
  }

 private:
  static constexpr std::uint32_t kActionSite = 0xAC7;
  static constexpr std::size_t kProbabilities = M::kExactUnits > 0
                                                    ? sizeof(typename M::Posterior) / sizeof(double)
                                                    : 0;
  static constexpr std::size_t kColumns =
      2 * M::kVariableCount + kProbabilities + 10 + SeesFirst<M>::value + kKeyWords<typename M::Key>;

  struct Lane {
    typename M::Fixed fixed;
    typename M::State state;
    typename M::History history;
    typename M::Posterior posterior;
  };

  void restart(std::uint32_t i, std::uint32_t t) {
    PhiloxDraws draws(key_, i, t);
    M::init_visible(params_, draws, lanes_[i].fixed, lanes_[i].state);
    M::init_hidden(params_, draws, lanes_[i].fixed, lanes_[i].state);
    M::init_history(params_, lanes_[i].fixed, lanes_[i].state, lanes_[i].history);
    M::init_posterior(params_, lanes_[i].fixed, lanes_[i].state, lanes_[i].posterior);
  }

  // Appends the row of one lane and moves it on; false if the lane has ended.
  bool step(std::uint32_t i, std::uint32_t t) {
    Lane& lane = lanes_[i];
    PhiloxDraws draws(key_, i, t);
    put_variables(lane.state, lane.fixed);
    put_posterior(lane.posterior);
    if constexpr (SeesFirst<M>::value) {
      put_double(M::init_likelihood(params_, lane.fixed, lane.state));
    }
    put(M::default_policy(params_, lane.fixed, lane.state, lane.history, draws));
    const int action = choose_action(lane, i, t);
    put(action);
    if (action < 0) {
      row_.resize(kColumns);
      return false;
    }
    typename M::State next{};
    const StepResult result = M::step(params_, lane.fixed, lane.state, action, draws, next);
    const bool goes_on = !result.terminal;
    typename M::Key key{};
    if (goes_on) key = M::observe(params_, lane.fixed, lane.state, action, draws, next);
    put(result.reward);
    put(result.terminal);
    put(result.success);
    for (const std::uint64_t word : words_of(key)) put(static_cast<std::int64_t>(word));
    put_float(declared_upper(lane));
    put_float(M::tail(params_, lane.fixed, lane.state));
    put_float(DeclaresLower<M>::value ? M::lower(params_, lane.fixed, lane.state, lane.history) : 0.0F);
    if (goes_on) {
      put_double(M::observation_density(params_, lane.fixed, lane.state, action, key, draws, next));
      put_filter(lane, i, t, action, key);
      advance(lane, action, key, draws, next);
    } else {
      row_.resize(kColumns);
    }
    lane.state = next;
    return goes_on;
  }

  // Takes what was seen into the lane's history; notes whether a rollout would have come to another one.
  void advance(Lane& lane, int action, const typename M::Key& key, PhiloxDraws& draws,
               const typename M::State& next) {
    typename M::History after, rolled;
    M::advance_history(params_, lane.fixed, lane.state, action, key, next, lane.history, after);
    if constexpr (M::kHasHistory) {
      M::roll_history(params_, lane.fixed, lane.state, action, draws, next, lane.history, rolled);
      histories_agree_ = histories_agree_ && std::memcmp(&after, &rolled, sizeof after) == 0;
    }
    lane.history = after;
    const typename M::Posterior before = lane.posterior;
    M::advance_posterior(params_, lane.fixed, lane.state, action, key, next, before, lane.posterior);
  }

  // What the model's text says: the interpreter knows no derived tables.
  float declared_upper(const Lane& lane) const {
    if constexpr (IsRelaxed<M>::value) return M::declared_upper(params_, lane.fixed, lane.state);
    return M::upper(params_, lane.fixed, lane.state);
  }

  void put_filter(const Lane& lane, std::uint32_t i, std::uint32_t t, int action,
                  const typename M::Key& key) {
    PhiloxDraws draws(filter_key_, i, t);
    typename M::State next{};
    const double weight = M::filter(params_, lane.fixed, lane.state, action, key, draws, next);
    put_double(weight);
    put_variables(next, lane.fixed);
  }

  int choose_action(const Lane& lane, std::uint32_t i, std::uint32_t t) {
    legal_.clear();
    for (int action = 0; action < M::kActionCount; ++action) {
      if (M::is_legal(params_, lane.fixed, lane.state, action)) legal_.push_back(action);
    }
    if (legal_.empty()) return -1;
    PhiloxDraws draws(key_, i, t);
    return legal_[(std::uint64_t{draws.word(kActionSite, 0)} * legal_.size()) >> 32];
  }

  void put(std::int64_t value) { row_.push_back(value); }
  void put_float(float value) { put(math::canonical_bits(value)); }
  void put_double(double value) { put(static_cast<std::int64_t>(math::canonical_bits(value))); }

  void put_variables(const typename M::State& state, const typename M::Fixed& fixed) {
    std::int32_t values[M::kVariableCount];
    M::export_state(fixed, state, values);
    for (const std::int32_t value : values) put(value);
  }

  void put_posterior(const typename M::Posterior& posterior) {
    double values[kProbabilities + 1];
    std::memcpy(values, &posterior, kProbabilities * sizeof(double));
    for (std::size_t i = 0; i < kProbabilities; ++i) put_double(values[i]);
  }

  void write_row(Output& out) const {
    std::string bytes;
    for (const std::int64_t value : row_) {
      for (int i = 0; i < 64; i += 8) bytes += static_cast<char>(static_cast<std::uint64_t>(value) >> i);
    }
    out.write(bytes);
  }

  const typename M::Params& params_;
  TraceOptions options_;
  StreamKey key_;
  StreamKey filter_key_;
  std::vector<Lane> lanes_;
  std::vector<int> legal_;
  std::vector<std::int64_t> row_;
  bool histories_agree_ = true;
};

}  // namespace hypgen
