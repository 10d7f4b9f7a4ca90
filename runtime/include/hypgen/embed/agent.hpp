// SPDX-License-Identifier: Apache-2.0
// An agent: a planner and the belief that it plans for, in a program of the user's own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/core/span.hpp"
#include "hypgen/core/status.hpp"
#include "hypgen/model/embedded_model.hpp"
#include "hypgen/model/key_codec.hpp"
#include "hypgen/search/decision.hpp"
#include "hypgen/search/planner.hpp"
#include "hypgen/solver/options.hpp"
#include "hypgen/solver/tree_text.hpp"

namespace hypgen {

struct AgentOptions {
  // Options of the solver about planning, without their dashes, between blanks: "mode=despot time=0.05".
  std::string settings;
  std::string params;  // a JSON object as of --param; empty: the model's own values
};

// All calls come from one thread at a time. A call whose argument is wrong gives kWrongArgument and `error`, and
// changes nothing. `error` is left alone otherwise.
class Agent {
 public:
  // Null, with `status` and `error`, if an option is wrong, there is no memory, or a GPU is required and missing.
  static std::unique_ptr<Agent> create(EmbeddedModel model, const AgentOptions& options, Status& status,
                                       std::string& error);

  // The same with options that were read before.
  static std::unique_ptr<Agent> create(EmbeddedModel model, const SolverOptions& options, ParamValues values,
                                       Status& status, std::string& error);

  // Starts an episode. `visible` has the values of all visible variables; it may be empty if the model draws
  // none of them. The episode's number names the draws of belief and search. If nothing explains what is
  // visible, the status says so, and the belief is what the model says of hidden variables alone.
  Status reset(Span<const std::int32_t> visible, std::uint64_t episode, std::string& error);

  // The same with a JSON object of visible variables. One that is left out starts as the model says; one that
  // the model draws may not be left out.
  Status reset(const std::string& visible, std::uint64_t episode, std::string& error);

  // Decides within so many seconds, or for 0 within the settings' time, or what the last update has left of their
  // period. The status is the decision's. The action
  // is legal unless the status is kNoLegalAction or kWrongArgument.
  Status plan(double seconds, Decision& decision, std::string& error);

  // Ends the plan that another thread has under way, if any, as its deadline would. From any thread.
  void cancel() { planner_->cancel(); }

  // Plays a step that counts nowhere: plans for so many seconds, or the settings' time, acts in a simulated world,
  // and updates the belief. So the first plan of an episode finds its memory touched and its device awake. Ends
  // the episode, if there is one; the first of the next is a reset.
  Status warm_up(double seconds, std::string& error);

  // Takes in what was done and seen. If the status is neither kOk nor kWrongArgument, no particle explains what
  // was seen; the belief has moved on without that evidence.
  Status update(int action, KeyWords key, std::string& error);

  // The key of values, or of a JSON object of all fields of `model().seen`.
  Status encode(Span<const std::int32_t> values, std::vector<std::uint64_t>& key, std::string& error) const;
  Status encode(const std::string& seen, std::vector<std::uint64_t>& key, std::string& error) const;

  // The JSON object of a key.
  Status decode(KeyWords key, std::string& seen, std::string& error) const;

  // The number of the action of this name.
  Status find_action(const std::string& name, int& action, std::string& error) const;

  // The belief in all hidden variables: a JSON array as in the lines of --details.
  Status describe_belief(std::string& text, std::string& error) const;

  // How far each unit of the belief can be trusted; none before an episode.
  std::vector<UnitHealth> health() const {
    return has_begun_ ? belief_->health() : std::vector<UnitHealth>{};
  }

  // Draws states from the belief, and writes all variables' values of each, `model().descriptor.variable_count`
  // of them, in the order of export_state.
  Status sample_belief(std::uint64_t seed, std::size_t count, std::int32_t* out, std::string& error) const;

  // The tree that the last plan decided by, as `tree_text` gives it.
  Status describe_tree(const TreeExtent& extent, std::string& text, std::string& error);

  // The probability that a hidden variable, named with its indices, has the value of this name. Not of floats.
  Status probability(const std::string& variable, const std::string& value, double& out,
                     std::string& error) const;

  const EmbeddedModel& model() const { return model_; }
  const SolverOptions& options() const { return options_; }
  std::size_t threads() const { return planner_->threads(); }
  const std::string& device() const { return device_; }  // "cpu" or "cuda:N"
  const std::string& device_problem() const {
    return problem_;
  }  // why it is the CPU, where a GPU was asked for
  int step() const { return step_; }

 private:
  Agent(EmbeddedModel model, const SolverOptions& options, std::unique_ptr<ModelInstance> instance);

  bool start(Status& status, std::string& error);
  std::unique_ptr<LeafEvaluator> fall_back(const std::string& problem);
  static bool check_seconds(double seconds, std::string& error);
  static bool check_episode(std::uint64_t episode, std::string& error);
  Status begin(const std::vector<std::int32_t>& visible, std::uint64_t episode);
  Status check_begun(std::string& error) const;

  EmbeddedModel model_;
  SolverOptions options_;
  std::unique_ptr<ModelInstance> instance_;
  KeyCodec codec_;
  std::vector<std::int32_t> decoded_;        // scratch of `update`
  std::vector<std::int32_t> first_visible_;  // as the model starts
  std::unique_ptr<Planner> planner_;
  std::unique_ptr<Belief> belief_;  // its updates use the planner's threads
  std::string device_;
  std::string problem_;
  std::uint64_t episode_ = 0;
  int step_ = 0;
  double update_seconds_ = 0.0;  // of the last update
  bool has_begun_ = false;
  bool has_tree_ = false;  // the last plan has looked ahead
};

}  // namespace hypgen
