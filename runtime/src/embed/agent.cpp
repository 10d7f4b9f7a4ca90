// SPDX-License-Identifier: Apache-2.0
#include "hypgen/embed/agent.hpp"

#include <algorithm>
#include <iterator>
#include <new>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "../model/input_text.hpp"
#include "../solver/marginal_json.hpp"
#include "../solver/settings.hpp"
#include "hypgen/episode/world.hpp"
#include "hypgen/model/params.hpp"
#include "hypgen/model/value_text.hpp"
#include "hypgen/solver/device_choice.hpp"
#include "hypgen/solver/step_details.hpp"

namespace hypgen {

namespace {

constexpr double kMostSeconds = 1e6;
constexpr std::uint64_t kSampleStream = std::uint64_t{1} << 33;  // other tests take the ones before

Status refuse(std::string text, std::string& error) {
  error = std::move(text);
  return Status::kWrongArgument;
}

bool read_settings(const std::string& text, const ModelDescriptor& model, SolverOptions& options,
                   std::string& error) {
  std::istringstream words(text);
  std::vector<std::string> arguments;
  for (std::string word; words >> word;) {
    const std::string name = word.substr(0, word.find('='));
    if (!is_setting(name)) {
      error = "no setting is named " + excerpt(name) + "; the settings are:";
      for (const char* known : kSettings) error += std::string(" ") + known;
      return false;
    }
    arguments.push_back("--" + word);
  }
  std::vector<const char*> argv = {"agent"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  return parse_options(static_cast<int>(argv.size()), argv.data(), this_machine(model.device), options,
                       error);
}

std::unique_ptr<Agent> without_memory(Status& status, std::string& error) {
  status = Status::kNoMemory;
  error = "not enough memory; the settings memory, particles and scenarios lower the need";
  return nullptr;
}

}  // namespace

std::unique_ptr<Agent> Agent::create(EmbeddedModel model, const AgentOptions& options, Status& status,
                                     std::string& error) {
  status = Status::kWrongArgument;
  const ModelDescriptor& descriptor = model.descriptor;
  try {
    SolverOptions parsed;
    if (!read_settings(options.settings, descriptor, parsed, error)) return nullptr;
    ParamValues values(descriptor.params);
    if (!options.params.empty() && !read_params(options.params, descriptor.params, values, error))
      return nullptr;
    return create(std::move(model), parsed, values, status, error);
  } catch (const std::bad_alloc&) {
    return without_memory(status, error);
  }
}

std::unique_ptr<Agent> Agent::create(EmbeddedModel model, const SolverOptions& options, ParamValues values,
                                     Status& status, std::string& error) {
  status = Status::kWrongArgument;
  const ModelDescriptor& descriptor = model.descriptor;
  if (options.belief == BeliefKind::kFactored && !descriptor.factored) {
    error = "--belief: this model's belief does not factor";
    return nullptr;
  }
  try {
    if (!read_plan_params(options.plan_params, descriptor.params, values, error)) return nullptr;
    if (!check_complete(descriptor.params, values, error)) return nullptr;
    auto instance = descriptor.create(values, error);
    if (!instance) return nullptr;
    std::unique_ptr<Agent> agent(new Agent(std::move(model), options, std::move(instance)));
    return agent->start(status, error) ? std::move(agent) : nullptr;
  } catch (const std::bad_alloc&) {
    return without_memory(status, error);
  }
}

Agent::Agent(EmbeddedModel model, const SolverOptions& options, std::unique_ptr<ModelInstance> instance)
    : model_(std::move(model)),
      options_(options),
      instance_(std::move(instance)),
      codec_(model_.seen, model_.key_words),
      decoded_(codec_.values()) {}

bool Agent::start(Status& status, std::string& error) {
  const ModelDescriptor& descriptor = model_.descriptor;
  ChosenEvaluator chosen = choose_evaluator(descriptor, *instance_, options_);
  if (!chosen.problem.empty() && options_.require_gpu) {
    status = Status::kNoGpu;
    error = chosen.problem;
    return false;
  }
  device_ = chosen.device;
  problem_ = chosen.problem;
  planner_ = std::make_unique<Planner>(std::move(chosen.evaluator), descriptor, options_.planner);
  planner_->set_fallback([this](const std::string& problem) { return fall_back(problem); });
  belief_ = instance_->make_belief(options_.planner.seed, options_.particles, options_.belief);
  planner_->prepare(*belief_);
  first_visible_.resize(static_cast<std::size_t>(descriptor.visible_count));
  std::vector<std::int32_t> visible(first_visible_.size() + 1);
  const auto world = instance_->make_world(options_.planner.seed);
  world->reset(0);
  world->export_visible(visible.data());
  std::copy_n(visible.begin(), first_visible_.size(), first_visible_.begin());
  status = Status::kOk;
  return true;
}

// What plans once a GPU is lost; null where a GPU is required or memory is short, and the default policy acts.
std::unique_ptr<LeafEvaluator> Agent::fall_back(const std::string& problem) {
  problem_ = "the GPU was lost" + (problem.empty() ? "" : " (" + problem + ")");
  if (options_.require_gpu) return nullptr;
  try {
    auto made = instance_->make_evaluator(evaluator_options(options_.planner, model_.descriptor));
    device_ = "cpu";
    return made;
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

// Random numbers have names of 64 bits: the episode's, and 20 bits of the step's.
bool Agent::check_episode(std::uint64_t episode, std::string& error) {
  if (episode < std::uint64_t{1} << 44) return true;
  error = "episode: expected a number below 2^44, found " + std::to_string(episode);
  return false;
}

Status Agent::begin(const std::vector<std::int32_t>& visible, std::uint64_t episode) {
  has_begun_ = false;  // nor does an episode begin that an exception ends
  episode_ = episode;
  step_ = 0;
  update_seconds_ = 0.0;
  std::vector<std::int32_t> values = visible;
  values.push_back(0);  // never empty
  const Status status = belief_->init(values.data(), episode);
  has_begun_ = true;
  return status;
}

Status Agent::reset(Span<const std::int32_t> visible, std::uint64_t episode, std::string& error) {
  if (visible.empty()) return reset(std::string("{}"), episode, error);
  if (!check_episode(episode, error)) return Status::kWrongArgument;
  if (!check_values(model_.visible, visible, error)) return Status::kWrongArgument;
  return begin({visible.begin(), visible.end()}, episode);
}

Status Agent::reset(const std::string& visible, std::uint64_t episode, std::string& error) {
  if (!check_episode(episode, error)) return Status::kWrongArgument;
  std::vector<std::int32_t> values = first_visible_;
  std::vector<bool> given;
  if (!read_values(visible, model_.visible, values, given, error)) return Status::kWrongArgument;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const ValueField& field = model_.visible[i];
    if (field.drawn && !given[i])
      return refuse(field.name + ": the model draws its first value, so say what it is", error);
  }
  return begin(values, episode);
}

Status Agent::check_begun(std::string& error) const {
  return has_begun_ ? Status::kOk : refuse("no episode has begun: reset comes first", error);
}

bool Agent::check_seconds(double seconds, std::string& error) {
  if (0.0 <= seconds && seconds <= kMostSeconds) return true;
  error = "seconds: expected a number from 0 (the settings' time) to 1e6";
  return false;
}

Status Agent::plan(double seconds, Decision& decision, std::string& error) {
  if (check_begun(error) != Status::kOk) return Status::kWrongArgument;
  if (!check_seconds(seconds, error)) return Status::kWrongArgument;
  const PlannerOptions& planning = options_.planner;
  const double own =
      planning.period > 0.0 ? rest_of_period(planning.period, update_seconds_) : planning.time_limit;
  planner_->set_time_limit(seconds > 0.0 ? seconds : own);
  decision = planner_->plan(*belief_, episode_, step_);
  has_tree_ = decision.keeps_tree;
  if (decision.status == Status::kDeadline && decision.looked == Looked::kNowhere)
    decision.status = Status::kDeadlineDefault;
  return decision.status;
}

Status Agent::warm_up(double seconds, std::string& error) {
  if (!check_seconds(seconds, error)) return Status::kWrongArgument;
  const auto world = instance_->make_world(options_.planner.seed);
  world->reset(0);
  begin(first_visible_, 0);  // as in episode 0 of that world
  Decision decision;
  const Status status = plan(seconds, decision, error);
  if (decision.action >= 0) {
    const WorldStep step = world->step(decision.action);
    if (!step.result.terminal) update(decision.action, step.key, error);
  }
  has_begun_ = false;
  return status;
}

Status Agent::update(int action, KeyWords key, std::string& error) {
  if (check_begun(error) != Status::kOk) return Status::kWrongArgument;
  const ModelDescriptor& descriptor = model_.descriptor;
  if (action < 0 || action >= descriptor.action_count) {
    return refuse("action: expected a number from 0 to " + std::to_string(descriptor.action_count - 1) +
                      ", found " + std::to_string(action),
                  error);
  }
  if (!codec_.decode(key, decoded_)) return refuse("key: no observation of the model has it", error);
  if (!check_values(model_.seen, {decoded_.data(), decoded_.size()}, error)) return Status::kWrongArgument;
  if (!belief_->is_legal(action)) {
    return refuse("action " + descriptor.action_names[static_cast<std::size_t>(action)] + " is not legal now",
                  error);
  }
  has_begun_ = false;  // an exception leaves a belief that is half moved: then only a reset helps
  const Clock::time_point start = Clock::now();
  const Status status = belief_->update(action, key);
  if (status != Status::kOk) belief_->propagate(action, key);
  update_seconds_ = std::chrono::duration<double>(Clock::now() - start).count();
  ++step_;
  has_begun_ = true;
  return status;
}

Status Agent::encode(Span<const std::int32_t> values, std::vector<std::uint64_t>& key,
                     std::string& error) const {
  if (!check_values(model_.seen, values, error)) return Status::kWrongArgument;
  codec_.encode(values, key);
  return Status::kOk;
}

Status Agent::encode(const std::string& seen, std::vector<std::uint64_t>& key, std::string& error) const {
  std::vector<std::int32_t> values(codec_.values());
  std::vector<bool> given;
  if (!read_values(seen, model_.seen, values, given, error)) return Status::kWrongArgument;
  const auto missing = std::find(given.begin(), given.end(), false);
  if (missing != given.end()) {
    const auto number = static_cast<std::size_t>(missing - given.begin());
    return refuse(model_.seen[number].name + ": its value is missing", error);
  }
  codec_.encode({values.data(), values.size()}, key);
  return Status::kOk;
}

Status Agent::decode(KeyWords key, std::string& seen, std::string& error) const {
  std::vector<std::int32_t> values;
  if (!codec_.decode(key, values)) return refuse("key: no observation of the model has it", error);
  seen = values_text(model_.seen, values);
  return Status::kOk;
}

Status Agent::find_action(const std::string& name, int& action, std::string& error) const {
  const std::vector<std::string>& names = model_.descriptor.action_names;
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    return refuse("no action is named " + excerpt(name) + "; the actions are: " + listed(names), error);
  action = static_cast<int>(found - names.begin());
  return Status::kOk;
}

Status Agent::describe_belief(std::string& text, std::string& error) const {
  if (check_begun(error) != Status::kOk) return Status::kWrongArgument;
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  std::size_t left_out = 0;
  for (const Marginal& marginal : marginals(model_.descriptor, *belief_, SIZE_MAX, SIZE_MAX, left_out))
    json.push_back(json_of(marginal));
  text = json.dump();
  return Status::kOk;
}

Status Agent::sample_belief(std::uint64_t seed, std::size_t count, std::int32_t* out,
                            std::string& error) const {
  if (check_begun(error) != Status::kOk) return Status::kWrongArgument;
  ScenarioBuffer states;
  belief_->reserve(states, count);
  belief_->sample(derive(seed, StreamKind::kTest, kSampleStream), 0, count, states);
  instance_->export_states(states, out);
  return Status::kOk;
}

Status Agent::describe_tree(const TreeExtent& extent, std::string& text, std::string& error) {
  if (extent.depth < 0 || extent.depth > TreeExtent::kMostDepth || extent.most < 1 || extent.nodes < 1)
    return refuse("depth, top or nodes: expected a depth from 0 to 100, and 1 or more of the others", error);
  const Tree& tree = planner_->tree_at_rest();
  if (!has_tree_ || tree.is_empty()) return refuse("the last plan has left no tree", error);
  const auto walk = instance_->walk(planner_->scenarios(), planner_->search_key(), tree.is_weighted());
  text = tree_text(model_, codec_, tree, *walk, extent).json;
  return Status::kOk;
}

Status Agent::probability(const std::string& variable, const std::string& value, double& out,
                          std::string& error) const {
  if (check_begun(error) != Status::kOk) return Status::kWrongArgument;
  const ModelDescriptor& model = model_.descriptor;
  for (std::size_t number = 0; number < model.hidden_variables.size(); ++number) {
    const HiddenVariable& hidden = model.hidden_variables[number];
    for (int i = 0; i < hidden.count; ++i) {
      if (entry_name(model, hidden, i) != variable) continue;
      if (hidden.is_float)
        return refuse(variable + " is a float, of which no value has a probability", error);
      std::int32_t code = 0;
      if (!read_value_name(model_.hidden[number], value, code, error)) return Status::kWrongArgument;
      out = belief_->marginal(hidden.first + i, code);
      return Status::kOk;
    }
  }
  std::vector<std::string> names;
  for (const HiddenVariable& hidden : model.hidden_variables) {
    for (int i = 0; i < hidden.count; ++i) names.push_back(entry_name(model, hidden, i));
  }
  return refuse("no hidden variable is named " + variable + "; the names are: " + listed(names), error);
}

}  // namespace hypgen
