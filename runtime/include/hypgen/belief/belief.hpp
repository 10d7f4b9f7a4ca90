// SPDX-License-Identifier: Apache-2.0
// The interface of a belief: the agent's knowledge of the state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "hypgen/core/status.hpp"
#include "hypgen/core/workers.hpp"
#include "hypgen/memory/scenario_buffer.hpp"
#include "hypgen/model/key.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

constexpr std::uint32_t kResampleSite = site_id("belief:resample");
constexpr std::uint32_t kSampleSite = site_id("belief:sample");

// How far the particles of a unit can be trusted after an update.
struct UnitHealth {
  std::size_t particles;
  double effective;      // sample size
  std::size_t distinct;  // values of its particles
  double surprise;   // bits by which what was seen was less probable than what was seen before, on average
  bool is_depleted;  // few values are left, of a unit that had many
};

class Belief {
 public:
  // As improbable as that, what was seen casts doubt on the belief.
  static constexpr double kDoubtfulSurprise = 20.0;

  virtual ~Belief() = default;

  // Whether anything is known of hidden variables.
  virtual bool knows_hidden() const { return true; }

  // Lets these threads share the work of `init` and `update`; null: the caller's thread does it all. Results
  // are the same.
  virtual void use(Workers* /*workers*/) {}

  // Starts episode `run` with the values of all visible variables, and with what these tell of hidden ones.
  // If the status is not kOk, nothing explains them, and the belief is what the model says of hidden ones
  // alone.
  virtual Status init(const std::int32_t* visible, std::uint64_t run) = 0;

  // Updates the belief by an action and the observation after it. If the status is not kOk, the belief stays
  // as it was.
  virtual Status update(int action, KeyWords key) = 0;

  // Moves the belief on where `update` could not explain the observation. Visible variables become those
  // seen. Hidden variables move by the model; evidence that contradicts all their values is ignored.
  virtual void propagate(int action, KeyWords key) = 0;

  // Gives a buffer the room that `sample` and `export_particles` need for `capacity` states.
  virtual void reserve(ScenarioBuffer& buffer, std::size_t capacity) const = 0;

  // Draws `count` scenarios, numbered from `first` on, with the agent's history.
  virtual void sample(StreamKey key, std::uint32_t first, std::size_t count, ScenarioBuffer& out) const = 0;

  // Whether the model allows an action in what is visible.
  virtual bool is_legal(int action) const = 0;

  // The default policy's action; -1 if no action is legal.
  virtual int default_action(StreamKey key) const = 0;

  // Calls `take` with each value that a variable (an index into the model's export_state) may have and its
  // weight. A value may come several times. The weights add up to 1.
  using TakeValue = std::function<void(std::int32_t value, double weight)>;
  virtual void each_value(int variable, const TakeValue& take) const = 0;

  // The probability that a variable has a value.
  double marginal(int variable, std::int32_t value) const {
    double sum = 0.0;
    each_value(variable, [&](std::int32_t other, double weight) { sum += other == value ? weight : 0.0; });
    return sum;
  }

  // Particles with the agent's history, and their weights, which add up to 1. `import_particles` takes
  // `size()` particles; false if it cannot take these.
  virtual void export_particles(ScenarioBuffer& particles, std::vector<double>& weights) const = 0;
  virtual bool import_particles(const ScenarioBuffer& particles, const std::vector<double>& weights) = 0;

  // The health of each unit with particles.
  virtual std::vector<UnitHealth> health() const { return {}; }

  virtual double effective_sample_size() const = 0;
  virtual std::size_t size() const = 0;
};

}  // namespace hypgen
