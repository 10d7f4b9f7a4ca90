// What the agent holds to be true.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hypgen/core/status.hpp"
#include "hypgen/memory/scenario_buffer.hpp"
#include "hypgen/model/key.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

// The id of a draw site of the runtime's own: FNV-1a of its path, as for a model's. The compiler keeps these
// free.
constexpr std::uint32_t site_id(const char* path) {
  std::uint32_t id = 0x811C9DC5;
  for (; *path != '\0'; ++path) id = (id ^ static_cast<unsigned char>(*path)) * 0x01000193;
  return id;
}
constexpr std::uint32_t kResampleSite = site_id("belief:resample");
constexpr std::uint32_t kSampleSite = site_id("belief:sample");

class Belief {
 public:
  virtual ~Belief() = default;

  // Starts episode `run`, given all visible variables.
  virtual void init(const std::int32_t* visible, std::uint64_t run) = 0;

  // Takes in an action and what was seen after it. Unless the status is kOk the belief stays as it was.
  virtual Status update(int action, KeyWords key) = 0;

  // Takes in what `update` could not explain: what is hidden moves on by the model, weighed by nothing that
  // contradicts all of it, and the visible variables are those seen.
  virtual void propagate(int action, KeyWords key) = 0;

  // Gives a buffer the room that `sample` and `export_particles` need.
  virtual void reserve(ScenarioBuffer& buffer, std::size_t capacity) const = 0;

  // Draws `count` scenarios with numbers from `first` on; they have the agent's history.
  virtual void sample(StreamKey key, std::uint32_t first, std::size_t count, ScenarioBuffer& out) const = 0;

  // What the default policy does now; -1 if no action is legal.
  virtual int default_action(StreamKey key) const = 0;

  // The probability that a variable (an index into the model's export_state) has a value.
  virtual double marginal(int variable, std::int32_t value) const = 0;

  // Particles with the agent's history, and their weights, which add up to 1. `import_particles` takes as
  // many as there are.
  virtual void export_particles(ScenarioBuffer& particles, std::vector<double>& weights) const = 0;
  virtual bool import_particles(const ScenarioBuffer& particles, const std::vector<double>& weights) = 0;

  virtual double effective_sample_size() const = 0;
  virtual std::size_t size() const = 0;
};

}  // namespace hypgen
