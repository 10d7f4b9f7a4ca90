// SPDX-License-Identifier: Apache-2.0
#include "hypgen/embed/c_api.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "c_calls.hpp"
#include "hypgen/embed/agent.hpp"

namespace hypgen {

hypgen_status code_of(Status status) {
  switch (status) {
    case Status::kOk:
    case Status::kTerminal:
    case Status::kStepLimit:
    case Status::kNotKept:
      return HYPGEN_OK;
    case Status::kDeadline:
      return HYPGEN_DEADLINE;
    case Status::kTrialLimit:
      return HYPGEN_TRIAL_LIMIT;
    case Status::kConverged:
      return HYPGEN_CONVERGED;
    case Status::kMemoryFull:
      return HYPGEN_MEMORY_FULL;
    case Status::kDepletedBelief:
      return HYPGEN_BELIEF_DEPLETED;
    case Status::kImpossibleObservation:
      return HYPGEN_IMPOSSIBLE_OBSERVATION;
    case Status::kAllParticlesTerminal:
      return HYPGEN_ALL_PARTICLES_TERMINAL;
    case Status::kNoLegalAction:
      return HYPGEN_NO_LEGAL_ACTION;
    case Status::kModelNan:
      return HYPGEN_MODEL_NAN;
    case Status::kCrossedBounds:
      return HYPGEN_BOUNDS_CROSSED;
    case Status::kEvaluatorFailed:
      return HYPGEN_EVALUATOR_FAILED;
    case Status::kDeviceLost:
      return HYPGEN_GPU_LOST;
    case Status::kDeadlineDefault:
      return HYPGEN_DEADLINE_DEFAULT;
    case Status::kNoGpu:
      return HYPGEN_NO_GPU;
    case Status::kNoMemory:
      return HYPGEN_NO_MEMORY;
    case Status::kWrongArgument:
      return HYPGEN_WRONG_ARGUMENT;
    case Status::kInterrupted:
      break;
  }
  return HYPGEN_INTERNAL_ERROR;
}

namespace {

// What a `hypgen_planner` stands for.
struct LivePlanner : Handled {
  static constexpr Kind kKind = Kind::kPlanner;
  static constexpr const char* kIsNull = "planner: is NULL";
  static constexpr const char* kIsUnknown = "planner: was destroyed, or another library has made it";
  static constexpr const char* kIsBusy = "planner: another thread's call is under way";
  static constexpr const char* kIsForked =
      "planner: belongs to the process that made it, of which this one is a fork";

  LivePlanner() : Handled(kKind, true) {}

  std::unique_ptr<Agent> agent;
  std::vector<std::uint64_t> key{};  // scratch of updates
};

char* copied(const std::string& text) {
  char* const copy = strdup(text.c_str());
  if (copy == nullptr) throw std::bad_alloc();
  return copy;
}

template <class Run>
hypgen_status with_agent(hypgen_planner* planner, char** error, const Run& run) {
  return with_handle<LivePlanner>(
      planner, error, [&](LivePlanner& live, std::string& text) { return run(*live.agent, text); });
}

hypgen_status check_words(const Agent& agent, std::size_t words, std::string& text) {
  const std::size_t expected = agent.model().key_words;
  if (words == expected) return HYPGEN_OK;
  text = "words: expected " + std::to_string(expected) + ", found " + std::to_string(words);
  return HYPGEN_WRONG_ARGUMENT;
}

Status give(const std::vector<std::uint64_t>& words, std::uint64_t* key) {
  std::copy(words.begin(), words.end(), key);
  return Status::kOk;
}

hypgen_decision decision_of(const Agent& agent, const Decision& found, hypgen_status status) {
  hypgen_decision decision{};
  decision.action = found.action;
  decision.status = status;
  if (found.action >= 0)
    decision.action_name =
        agent.model().descriptor.action_names[static_cast<std::size_t>(found.action)].c_str();
  decision.lower = found.lower;
  decision.upper = found.upper;
  decision.seconds = found.search_seconds;
  decision.trials = found.trials;
  decision.expansions = found.expansions;
  decision.scenarios = found.scenarios;
  decision.max_depth = found.max_depth;
  return decision;
}

// Updates by what `encode` makes a key of.
template <class Encode>
hypgen_status update_encoded(hypgen_planner* planner, int32_t action, char** error, const Encode& encode) {
  return with_handle<LivePlanner>(planner, error, [&](LivePlanner& live, std::string& text) {
    std::vector<std::uint64_t>& key = live.key;
    const Status status = encode(*live.agent, key, text);
    return status == Status::kOk ? live.agent->update(action, {key.data(), key.size()}, text) : status;
  });
}

}  // namespace
}  // namespace hypgen

using hypgen::Agent;
using hypgen::Status;

extern "C" {

uint32_t hypgen_abi_version(void) { return HYPGEN_ABI_VERSION; }

const char* hypgen_status_name(int32_t status) {
  switch (status) {
    case HYPGEN_OK:
      return "ok";
    case HYPGEN_CONVERGED:
      return "converged";
    case HYPGEN_TRIAL_LIMIT:
      return "trial_limit";
    case HYPGEN_DEADLINE:
      return "deadline";
    case HYPGEN_DEADLINE_DEFAULT:
      return "deadline_default";
    case HYPGEN_MEMORY_FULL:
      return "memory_full";
    case HYPGEN_GPU_LOST:
      return "gpu_lost";
    case HYPGEN_MODEL_NAN:
      return "model_nan";
    case HYPGEN_BOUNDS_CROSSED:
      return "bounds_crossed";
    case HYPGEN_EVALUATOR_FAILED:
      return "evaluator_failed";
    case HYPGEN_BELIEF_DEPLETED:
      return "belief_depleted";
    case HYPGEN_IMPOSSIBLE_OBSERVATION:
      return "impossible_observation";
    case HYPGEN_ALL_PARTICLES_TERMINAL:
      return "all_particles_terminal";
    case HYPGEN_WRONG_ARGUMENT:
      return "wrong_argument";
    case HYPGEN_NO_LEGAL_ACTION:
      return "no_legal_action";
    case HYPGEN_NO_GPU:
      return "no_gpu";
    case HYPGEN_NO_MEMORY:
      return "no_memory";
    case HYPGEN_BUSY:
      return "busy";
    case HYPGEN_INTERNAL_ERROR:
      return "internal_error";
    default:
      return "unknown";
  }
}

void hypgen_free(char* text) { std::free(text); }

hypgen_status hypgen_describe(const hypgen_model* model, char** json, char** error) {
  if (error != nullptr) *error = nullptr;
  HYPGEN_NEED(json);
  *json = nullptr;
  const hypgen_status status = hypgen::check_model(model, error);
  if (status != HYPGEN_OK) return status;
  return hypgen::guarded(error, [&](std::string&) {
    *json = hypgen::copied(hypgen::describe(model->make()));
    return Status::kOk;
  });
}

hypgen_status hypgen_create(const hypgen_model* model, const hypgen_options* options,
                            hypgen_planner** planner, char** error) {
  if (error != nullptr) *error = nullptr;
  HYPGEN_NEED(planner);
  *planner = nullptr;
  const hypgen_status found = hypgen::check_model(model, error);
  if (found != HYPGEN_OK) return found;
  if (options != nullptr && options->size != sizeof(hypgen_options))
    return hypgen::wrong("options: its size is not sizeof(hypgen_options) of this library's hypgen.h", error);
  return hypgen::guarded(error, [&](std::string& text) {
    hypgen::AgentOptions given;
    if (options != nullptr && options->settings != nullptr) given.settings = options->settings;
    if (options != nullptr && options->params != nullptr) given.params = options->params;
    Status status = Status::kOk;
    auto made = std::make_unique<hypgen::LivePlanner>();
    made->agent = Agent::create(model->make(), given, status, text);
    if (!made->agent) return status;
    made->key.resize(made->agent->model().key_words);
    *planner = static_cast<hypgen_planner*>(hypgen::LiveHandles::add(std::move(made)));
    return status;
  });
}

hypgen_status hypgen_destroy(hypgen_planner* planner) {
  return hypgen::destroy(planner, hypgen::LivePlanner::kKind);
}

hypgen_status hypgen_info(hypgen_planner* planner, char** json, char** error) {
  if (json != nullptr) *json = nullptr;
  return hypgen::with_agent(planner, error, [&](Agent& agent, std::string& text) {
    if (json == nullptr) return text = "json: is NULL", Status::kWrongArgument;
    nlohmann::ordered_json info = {{"mode", hypgen::mode_name(agent.options().planner.mode)},
                                   {"threads", agent.threads()},
                                   {"seed", agent.options().planner.seed},
                                   {"step", agent.step()},
                                   {"device", agent.device()},
                                   {"device_problem", nullptr},
                                   {"units", nlohmann::ordered_json::array()}};
    for (const hypgen::UnitHealth& unit : agent.health()) {
      info["units"].push_back({{"particles", unit.particles},
                               {"effective", unit.effective},
                               {"distinct", unit.distinct},
                               {"surprise", unit.surprise},
                               {"depleted", unit.is_depleted}});
    }
    if (!agent.device_problem().empty()) info["device_problem"] = agent.device_problem();
    *json = hypgen::copied(info.dump());
    return Status::kOk;
  });
}

hypgen_status hypgen_reset(hypgen_planner* planner, const int32_t* visible, size_t count, uint64_t episode,
                           char** error) {
  return hypgen::with_agent(planner, error, [&](Agent& agent, std::string& text) {
    if (visible == nullptr && count > 0) return text = "visible: is NULL", Status::kWrongArgument;
    return agent.reset(hypgen::Span<const std::int32_t>(visible, count), episode, text);
  });
}

hypgen_status hypgen_reset_named(hypgen_planner* planner, const char* visible, uint64_t episode,
                                 char** error) {
  return hypgen::with_agent(planner, error, [&](Agent& agent, std::string& text) {
    return agent.reset(std::string(visible == nullptr ? "{}" : visible), episode, text);
  });
}

int64_t hypgen_now(void) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(hypgen::Clock::now().time_since_epoch())
      .count();
}

hypgen_status hypgen_plan(hypgen_planner* planner, double seconds, hypgen_decision* decision, char** error) {
  return hypgen::with_agent(planner, error, [&](Agent& agent, std::string& text) {
    if (decision == nullptr) return text = "decision: is NULL", Status::kWrongArgument;
    if (decision->size != sizeof(hypgen_decision))
      return text = "decision: its size is not sizeof(hypgen_decision); set it before each call",
             Status::kWrongArgument;
    hypgen::Decision found;
    const Status status = agent.plan(seconds, found, text);
    *decision = hypgen::decision_of(agent, found, hypgen::code_of(status));
    decision->size = sizeof(hypgen_decision);
    return status;
  });
}

hypgen_status hypgen_plan_until(hypgen_planner* planner, int64_t deadline, hypgen_decision* decision,
                                char** error) {
  const int64_t now = hypgen_now();
  constexpr int64_t kMost = 1'000'000'000'000'000;  // nanoseconds: as long as a plan may take
  const int64_t left = deadline > now ? std::min(kMost, deadline - now) : 1;  // 0: the settings' time
  return hypgen_plan(planner, static_cast<double>(left) * 1e-9, decision, error);
}

hypgen_status hypgen_cancel(hypgen_planner* planner) {
  using hypgen::LivePlanner;
  const auto cancel = [](hypgen::Handled& live) { static_cast<LivePlanner&>(live).agent->cancel(); };
  const hypgen::Refusal refusal = hypgen::LiveHandles::visit(planner, LivePlanner::kKind, cancel);
  return refusal == hypgen::Refusal::kNone ? HYPGEN_OK : HYPGEN_WRONG_ARGUMENT;
}

hypgen_status hypgen_warm_up(hypgen_planner* planner, double seconds, char** error) {
  return hypgen::with_agent(planner, error,
                            [&](Agent& agent, std::string& text) { return agent.warm_up(seconds, text); });
}

hypgen_status hypgen_update(hypgen_planner* planner, int32_t action, const uint64_t* key, size_t words,
                            char** error) {
  return hypgen::with_agent(planner, error, [&](Agent& agent, std::string& text) {
    if (key == nullptr) return text = "key: is NULL", Status::kWrongArgument;
    if (hypgen::check_words(agent, words, text) != HYPGEN_OK) return Status::kWrongArgument;
    return agent.update(action, {key, words}, text);
  });
}

hypgen_status hypgen_update_values(hypgen_planner* planner, int32_t action, const int32_t* seen, size_t count,
                                   char** error) {
  return hypgen::update_encoded(planner, action, error, [&](Agent& agent, auto& key, std::string& text) {
    if (seen == nullptr && count > 0) return text = "seen: is NULL", Status::kWrongArgument;
    return agent.encode(hypgen::Span<const std::int32_t>(seen, count), key, text);
  });
}

hypgen_status hypgen_update_named(hypgen_planner* planner, int32_t action, const char* seen, char** error) {
  return hypgen::update_encoded(planner, action, error, [&](Agent& agent, auto& key, std::string& text) {
    return agent.encode(std::string(seen == nullptr ? "{}" : seen), key, text);
  });
}

hypgen_status hypgen_encode(hypgen_planner* planner, const int32_t* seen, size_t count, uint64_t* key,
                            size_t words, char** error) {
  return hypgen::with_agent(planner, error, [&](Agent& agent, std::string& text) {
    if (key == nullptr || (seen == nullptr && count > 0)) {
      text = "key or seen: is NULL";
      return Status::kWrongArgument;
    }
    if (hypgen::check_words(agent, words, text) != HYPGEN_OK) return Status::kWrongArgument;
    std::vector<std::uint64_t> found;
    const Status status = agent.encode(hypgen::Span<const std::int32_t>(seen, count), found, text);
    return status == Status::kOk ? hypgen::give(found, key) : status;
  });
}

hypgen_status hypgen_encode_named(hypgen_planner* planner, const char* seen, uint64_t* key, size_t words,
                                  char** error) {
  return hypgen::with_agent(planner, error, [&](Agent& agent, std::string& text) {
    if (key == nullptr) return text = "key: is NULL", Status::kWrongArgument;
    if (hypgen::check_words(agent, words, text) != HYPGEN_OK) return Status::kWrongArgument;
    std::vector<std::uint64_t> found;
    const Status status = agent.encode(std::string(seen == nullptr ? "{}" : seen), found, text);
    return status == Status::kOk ? hypgen::give(found, key) : status;
  });
}

hypgen_status hypgen_decode(hypgen_planner* planner, const uint64_t* key, size_t words, char** seen,
                            char** error) {
  if (seen != nullptr) *seen = nullptr;
  return hypgen::with_agent(planner, error, [&](Agent& agent, std::string& text) {
    if (key == nullptr || seen == nullptr) return text = "key or seen: is NULL", Status::kWrongArgument;
    if (hypgen::check_words(agent, words, text) != HYPGEN_OK) return Status::kWrongArgument;
    std::string names;
    const Status status = agent.decode({key, words}, names, text);
    if (status == Status::kOk) *seen = hypgen::copied(names);
    return status;
  });
}

hypgen_status hypgen_find_action(hypgen_planner* planner, const char* name, int32_t* action, char** error) {
  return hypgen::with_agent(planner, error, [&](Agent& agent, std::string& text) {
    if (name == nullptr || action == nullptr) return text = "name or action: is NULL", Status::kWrongArgument;
    return agent.find_action(name, *action, text);
  });
}

hypgen_status hypgen_action_name(hypgen_planner* planner, int32_t action, const char** name, char** error) {
  return hypgen::with_agent(planner, error, [&](Agent& agent, std::string& text) {
    const std::vector<std::string>& names = agent.model().descriptor.action_names;
    if (name == nullptr || action < 0 || static_cast<std::size_t>(action) >= names.size()) {
      text = name == nullptr ? "name: is NULL" : "action: the model has none of this number";
      return Status::kWrongArgument;
    }
    *name = names[static_cast<std::size_t>(action)].c_str();
    return Status::kOk;
  });
}

hypgen_status hypgen_tree(hypgen_planner* planner, int32_t depth, int32_t top, int32_t nodes, char** json,
                          char** error) {
  if (json != nullptr) *json = nullptr;
  return hypgen::with_agent(planner, error, [&](Agent& agent, std::string& text) {
    if (json == nullptr) return text = "json: is NULL", Status::kWrongArgument;
    std::string found;
    const auto count = [](int32_t given) { return static_cast<std::size_t>(std::max(0, given)); };
    const Status status = agent.describe_tree({depth, count(top), count(nodes)}, found, text);
    if (status == Status::kOk) *json = hypgen::copied(found);
    return status;
  });
}

hypgen_status hypgen_belief(hypgen_planner* planner, char** json, char** error) {
  if (json != nullptr) *json = nullptr;
  return hypgen::with_agent(planner, error, [&](Agent& agent, std::string& text) {
    if (json == nullptr) return text = "json: is NULL", Status::kWrongArgument;
    std::string found;
    const Status status = agent.describe_belief(found, text);
    if (status == Status::kOk) *json = hypgen::copied(found);
    return status;
  });
}

hypgen_status hypgen_sample_belief(hypgen_planner* planner, uint64_t seed, size_t count, int32_t* values,
                                   size_t size, char** error) {
  return hypgen::with_agent(planner, error, [&](Agent& agent, std::string& text) {
    const auto each = static_cast<std::size_t>(agent.model().descriptor.variable_count);
    if (values == nullptr) return text = "values: is NULL", Status::kWrongArgument;
    if (count == 0 || count > size || size != count * each) {
      text = "size: expected count times " + std::to_string(each) + ", and a count above 0";
      return Status::kWrongArgument;
    }
    return agent.sample_belief(seed, count, values, text);
  });
}

hypgen_status hypgen_probability(hypgen_planner* planner, const char* variable, const char* value,
                                 double* probability, char** error) {
  return hypgen::with_agent(planner, error, [&](Agent& agent, std::string& text) {
    if (variable == nullptr || value == nullptr || probability == nullptr) {
      text = "variable, value or probability: is NULL";
      return Status::kWrongArgument;
    }
    return agent.probability(variable, value, *probability, text);
  });
}

}  // extern "C"
