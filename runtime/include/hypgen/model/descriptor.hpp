// SPDX-License-Identifier: Apache-2.0
// The description of a model: names, params and counts, and the maker of the parts that know its types.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hypgen/model/key.hpp"

namespace hypgen_lanes {
struct Kernel;
}

namespace hypgen {

class Belief;
class DeviceSupport;
class LeafEvaluator;
class ScenarioBuffer;
class ScenarioWalk;
class World;
class Worlds;
struct EvaluatorOptions;
struct StreamKey;

constexpr int kDescriptorVersion = 1;

// How a belief is kept.
enum class BeliefKind {
  kAuto,      // kFactored where the model allows it, otherwise kParticle
  kParticle,  // as particles, each a whole state
  kFactored,  // as a posterior of each independent factor
  kVisible,   // of what is visible alone
};

enum class ParamKind { kBool, kInt, kFloat, kProb, kEnum };

// A run-time constant of the model: what a parameter file may set.
struct ParamSpec {
  std::string name;
  ParamKind kind;
  double low;                              // smallest value allowed
  double high;                             // largest value allowed
  std::vector<int> dims;                   // empty for a scalar
  std::vector<double> defaults;            // row-major; empty where the user must give the values
  std::vector<std::string> value_names;    // kEnum (and records): the name of each code
  std::map<std::string, int> glyphs = {};  // kEnum: the codes that a character (UTF-8) stands for in a string

  std::size_t length() const {
    std::size_t product = 1;
    for (const int dim : dims) product *= static_cast<std::size_t>(dim);
    return product;
  }
};

// A hidden variable as the model declares it: one for all members of a family and all entries of an array.
struct HiddenVariable {
  std::string name;
  int first;  // of its values in export_state
  int count;  // of these
  bool is_float;
};

// A visible variable, likewise. In export_visible the values of one follow those of the one before.
struct VisibleVariable {
  std::string name;
  int count;  // 0 for a family without members
  bool is_array;
  bool is_float;
};

// Checked values of all params, row-major; every value (float32, int32, bool or code) is exact in a double.
class ParamValues {
 public:
  // All defaults; params without one are absent.
  explicit ParamValues(const std::vector<ParamSpec>& specs) {
    for (const ParamSpec& spec : specs) {
      if (!spec.defaults.empty()) values_[spec.name] = spec.defaults;
    }
  }
  ParamValues() = default;

  void set(const std::string& name, std::vector<double> values) { values_[name] = std::move(values); }
  bool has(const std::string& name) const { return values_.count(name) != 0; }

  // Copies `count` entries to `out`; on a missing param or another length gives false and says so in `error`.
  template <class T>
  bool copy(const char* name, T* out, std::size_t count, std::string& error) const {
    const auto found = values_.find(name);
    if (found == values_.end() || found->second.size() != count) {
      error = "param " + std::string(name) + ": expected " + std::to_string(count) + " value(s), found " +
              (found == values_.end() ? "none" : std::to_string(found->second.size()));
      return false;
    }
    for (std::size_t i = 0; i < count; ++i) out[i] = static_cast<T>(found->second[i]);
    return true;
  }

 private:
  std::map<std::string, std::vector<double>> values_;
};

// A model with its params: makes the parts of a solver that see the model's types.
class ModelInstance {
 public:
  virtual ~ModelInstance() = default;
  virtual std::unique_ptr<LeafEvaluator> make_evaluator(const EvaluatorOptions& options) const = 0;
  // Lets the host expand small leaves beside a device. `device` was made with half of the options' memory.
  virtual std::unique_ptr<LeafEvaluator> add_host(std::unique_ptr<LeafEvaluator> device,
                                                  const EvaluatorOptions& options) const = 0;
  virtual std::unique_ptr<Belief> make_belief(std::uint64_t seed, std::size_t particles,
                                              BeliefKind kind) const = 0;
  virtual std::unique_ptr<World> make_world(std::uint64_t seed) const = 0;
  // `digits` are those of an observation's key.
  virtual std::unique_ptr<Worlds> make_worlds(std::uint64_t seed, std::size_t count,
                                              std::vector<KeyDigit> digits) const = 0;
  // Walks the scenarios again of a search with this root and this key. `weighted`: its groups share scenarios. The
  // instance and `root` outlive the walk.
  virtual std::unique_ptr<ScenarioWalk> walk(const ScenarioBuffer& root, StreamKey key,
                                             bool weighted) const = 0;
  // Writes the values of each state of a belief of this model, one state after the other.
  virtual void export_states(const ScenarioBuffer& states, std::int32_t* out) const = 0;
  virtual const void* params() const = 0;  // the model's Params, for a device
};

// A model as the solver sees it. `make_descriptor` (solver/model_instance.hpp) fills in the type's facts.
struct ModelDescriptor {
  int version = kDescriptorVersion;
  std::string name;  // of the model, as in its file
  std::string file;  // base name of the model file
  std::string hash;  // SHA-256 of the model's text with all settings
  double discount = 0.95;
  int horizon = 0;       // 0: none
  int reward_bits = 24;  // fraction bits of rewards in fixed point
  bool has_success = false;
  bool factored = false;   // a belief may be kept factor by factor
  bool rolls_out = false;  // leaves are bounded from below by rollouts, and not in closed form
  int action_count = 0;
  int visible_count = 0;
  int variable_count = 0;
  std::vector<std::string> action_names;
  std::vector<std::string> variable_names;  // flattened, in the order of export_state; may be empty
  std::vector<HiddenVariable> hidden_variables;
  std::vector<VisibleVariable> visible_variables;
  // The name of a value of hidden_variables[variable]; empty where all are numbers.
  std::function<std::string(int variable, std::int32_t value)> hidden_value_name;
  std::function<std::string(KeyWords)> observation_name;
  // Of the values of all visible variables at the start, those that tell of hidden ones; empty without any.
  std::function<std::string(const std::int32_t*)> first_observation_name;
  // Bounds and rewards that may be no number, each with its place: "reward 'joy' (m.pomdp:14)".
  std::vector<std::string> doubtful;
  std::vector<ParamSpec> params;
  std::function<std::unique_ptr<ModelInstance>(const ParamValues&, std::string& error)> create;
  // What rolls out many scenarios at a time, the widest first: of the kinds of processors that the solver is
  // compiled for. They live as long as the program.
  std::vector<const hypgen_lanes::Kernel*> lanes;
  const DeviceSupport* device = nullptr;  // lives as long as the program; null in a solver without CUDA
};

}  // namespace hypgen
