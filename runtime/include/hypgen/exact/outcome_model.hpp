// SPDX-License-Identifier: Apache-2.0
// A generated model as enumeration sees it: states and what is seen are words, and a step gives all outcomes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "hypgen/model/key.hpp"
#include "hypgen/model/model.hpp"
#include "hypgen/random/enumerating_draws.hpp"

namespace hypgen::exact {

// The outcomes of a step that do not end the episode, or initial states, each with its probability; the same
// outcome may stand there several times. `states` and `keys` have as many words for each as the model says.
struct Outcomes {
  std::vector<double> probabilities;
  std::vector<std::uint32_t> states;
  std::vector<std::uint64_t> keys;
  double reward = 0.0;  // expected, of those too that end the episode
  bool error = false;   // a reward was NaN

  void clear() {
    probabilities.clear();
    states.clear();
    keys.clear();
    reward = 0.0;
    error = false;
  }
};

class OutcomeModel {
 public:
  virtual ~OutcomeModel() = default;

  virtual int actions() const = 0;
  virtual int variables() const = 0;
  virtual int visible() const = 0;      // variables
  virtual int state_words() const = 0;  // equal words, equal states
  virtual int key_words() const = 0;

  // Both give false, and some of the outcomes, where there are more than `most` paths through the draws.
  virtual bool start(std::size_t most, Outcomes& out) const = 0;
  virtual bool step(const std::uint32_t* state, int action, std::size_t most, Outcomes& out) const = 0;

  virtual bool is_legal(const std::uint32_t* state, int action) const = 0;
  virtual void export_visible(const std::uint32_t* state, std::int32_t* out) const = 0;
  virtual void export_state(const std::uint32_t* state, std::int32_t* out) const = 0;
};

template <class M>
class TypedOutcomeModel final : public OutcomeModel {
 public:
  explicit TypedOutcomeModel(const typename M::Params& params) : params_(params) {}

  int actions() const override { return M::kActionCount; }
  int variables() const override { return M::kVariableCount; }
  int visible() const override { return M::kVisibleCount; }
  int state_words() const override { return sizeof(Both) / sizeof(std::uint32_t); }
  int key_words() const override { return kKeyWords<typename M::Key>; }

  bool start(std::size_t most, Outcomes& out) const override {
    out.clear();
    EnumeratingDraws draws;
    do {
      Both first;
      M::init_visible(params_, draws, first.fixed, first.state);
      M::init_hidden(params_, draws, first.fixed, first.state);
      if (out.probabilities.size() == most) return false;
      add(draws.probability(), first, out);
    } while (draws.next());
    return true;
  }

  bool step(const std::uint32_t* state, int action, std::size_t most, Outcomes& out) const override {
    out.clear();
    const Both from = read(state);
    Both next = from;
    EnumeratingDraws draws;
    for (std::size_t paths = 1;; ++paths) {
      const StepResult result = M::step(params_, from.fixed, from.state, action, draws, next.state);
      typename M::Key key{};
      if (!result.terminal) key = M::observe(params_, from.fixed, from.state, action, draws, next.state);
      out.reward += draws.probability() * from_fixed_sum<kRewardBits<M>>(result.reward);
      out.error |= result.is_broken();
      if (!result.terminal) {
        add(draws.probability(), next, out);
        const KeyWords words = words_of(key);
        out.keys.insert(out.keys.end(), words.begin(), words.end());
      }
      if (!draws.next()) return true;
      if (paths == most) return false;
    }
  }

  bool is_legal(const std::uint32_t* state, int action) const override {
    const Both at = read(state);
    return M::is_legal(params_, at.fixed, at.state, action);
  }

  void export_visible(const std::uint32_t* state, std::int32_t* out) const override {
    const Both at = read(state);
    M::export_visible(at.fixed, at.state, out);
  }

  void export_state(const std::uint32_t* state, std::int32_t* out) const override {
    const Both at = read(state);
    M::export_state(at.fixed, at.state, out);
  }

 private:
  struct Both {
    typename M::Fixed fixed;
    typename M::State state;
  };

  static Both read(const std::uint32_t* words) {
    Both both;
    std::memcpy(&both, words, sizeof both);
    return both;
  }

  void add(double probability, const Both& both, Outcomes& out) const {
    out.probabilities.push_back(probability);
    const std::size_t end = out.states.size();
    out.states.resize(end + sizeof both / sizeof(std::uint32_t));
    std::memcpy(&out.states[end], &both, sizeof both);
  }

  const typename M::Params& params_;
};

}  // namespace hypgen::exact
