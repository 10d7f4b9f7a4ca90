// SPDX-License-Identifier: Apache-2.0
#include "hypgen/embed/serve.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <initializer_list>
#include <new>
#include <nlohmann/json.hpp>
#include <vector>

#include "../model/input_text.hpp"
#include "hypgen/embed/c_api.hpp"

namespace hypgen {

namespace {

using Json = nlohmann::ordered_json;
using InputJson = nlohmann::json;

constexpr const char* kRequests = "describe, reset, plan, update, belief and quit";

// A request in the making of its answer. Each part gives the status; the answer holds what it found.
class Request {
 public:
  Request(Agent& agent, const InputJson& json) : agent_(agent), json_(json) {}

  Status answer(Json& out, std::string& error, bool& ends) {
    const auto found = json_.find("do");
    if (found == json_.end() || !found->is_string())
      return refuse(std::string("expected {\"do\": ..} with one of ") + kRequests, error);
    const std::string name = found->get<std::string>();
    if (name == "describe") return knows({}, error) ? describe(out) : Status::kWrongArgument;
    if (name == "reset") return knows({"visible", "episode"}, error) ? reset(error) : Status::kWrongArgument;
    if (name == "plan") return knows({"seconds"}, error) ? plan(out, error) : Status::kWrongArgument;
    if (name == "update")
      return knows({"action", "seen", "key"}, error) ? update(error) : Status::kWrongArgument;
    if (name == "belief") return knows({}, error) ? belief(out, error) : Status::kWrongArgument;
    if (name != "quit")
      return refuse("no request is named " + excerpt(name) + "; there are " + kRequests, error);
    ends = knows({}, error);
    return ends ? Status::kOk : Status::kWrongArgument;
  }

 private:
  static Status refuse(std::string text, std::string& error) {
    error = std::move(text);
    return Status::kWrongArgument;
  }

  // Whether all members of the request are known.
  bool knows(std::initializer_list<const char*> members, std::string& error) const {
    for (const auto& item : json_.items()) {
      const std::string& key = item.key();
      if (key == "do" || key == "id" || std::find(members.begin(), members.end(), key) != members.end())
        continue;
      error = excerpt(key) + ": this request has no such member";
      return false;
    }
    return true;
  }

  Status describe(Json& out) const {
    out["model"] = Json::parse(hypgen::describe(agent_.model()));
    out["mode"] = mode_name(agent_.options().planner.mode);
    out["threads"] = agent_.threads();
    out["device"] = agent_.device();
    if (!agent_.device_problem().empty()) out["device_problem"] = agent_.device_problem();
    return Status::kOk;
  }

  Status reset(std::string& error) {
    std::uint64_t episode = 0;
    const auto number = json_.find("episode");
    if (number != json_.end()) {
      if (!number->is_number_unsigned()) return refuse("episode: expected a number of 0 or more", error);
      episode = number->get<std::uint64_t>();
    }
    const auto visible = json_.find("visible");
    return agent_.reset(visible == json_.end() ? std::string("{}") : visible->dump(), episode, error);
  }

  Status plan(Json& out, std::string& error) {
    double seconds = 0.0;
    const auto limit = json_.find("seconds");
    if (limit != json_.end()) {
      if (!limit->is_number()) return refuse("seconds: expected a number", error);
      seconds = limit->get<double>();
    }
    Decision decision;
    const Status status = agent_.plan(seconds, decision, error);
    if (decision.action < 0) return status;
    const std::vector<std::string>& names = agent_.model().descriptor.action_names;
    out["action"] = decision.action;
    out["action_name"] = names[static_cast<std::size_t>(decision.action)];
    out["lower"] = std::isfinite(decision.lower) ? Json(decision.lower) : Json(nullptr);
    out["upper"] = std::isfinite(decision.upper) ? Json(decision.upper) : Json(nullptr);
    out["pruning"] = decision.pruning;
    out["seconds"] = decision.search_seconds;
    out["scenarios"] = decision.scenarios;
    out["trials"] = decision.trials;
    out["expansions"] = decision.expansions;
    out["max_depth"] = decision.max_depth;
    return status;
  }

  Status update(std::string& error) {
    const auto action = json_.find("action");
    if (action == json_.end() || json_.contains("seen") == json_.contains("key"))
      return refuse("update: it takes action, and seen or key", error);
    int number = -1;
    if (action->is_string()) {
      const Status status = agent_.find_action(action->get<std::string>(), number, error);
      if (status != Status::kOk) return status;
    } else if (action->is_number_integer()) {
      const double value = action->get<double>();
      const int last = agent_.model().descriptor.action_count - 1;
      if (!(0.0 <= value && value <= last)) {
        return refuse(
            "action: expected a number from 0 to " + std::to_string(last) + ", found " + action->dump(),
            error);
      }
      number = static_cast<int>(value);
    } else {
      return refuse("action: expected its name or number", error);
    }
    std::vector<std::uint64_t> key;
    const Status status = read_key(key, error);
    return status == Status::kOk ? agent_.update(number, {key.data(), key.size()}, error) : status;
  }

  // The key of what was seen: that of named values, or a number or array of numbers as JSON lines have it.
  Status read_key(std::vector<std::uint64_t>& key, std::string& error) const {
    if (json_.contains("seen")) return agent_.encode(json_["seen"].dump(), key, error);
    const InputJson& given = json_["key"];
    const InputJson words = given.is_array() ? given : InputJson::array({given});
    for (const InputJson& word : words) {
      if (!word.is_number_unsigned())
        return refuse("key: expected a number of 0 or more, or an array", error);
      key.push_back(word.get<std::uint64_t>());
    }
    return Status::kOk;
  }

  Status belief(Json& out, std::string& error) const {
    std::string text;
    const Status status = agent_.describe_belief(text, error);
    if (status == Status::kOk) out["belief"] = Json::parse(text);
    return status;
  }

  Agent& agent_;
  const InputJson& json_;
};

}  // namespace

std::string answer(Agent& agent, const std::string& request, bool& ends) {
  ends = false;
  Json out = {{"status", nullptr}};
  std::string error;
  hypgen_status code = HYPGEN_INTERNAL_ERROR;
  try {
    InputJson json;
    Status status = Status::kWrongArgument;
    if (!parse_json(request, json, error)) {
      error = "expected a JSON object on one line: " + error;
    } else if (json.is_object()) {
      if (json.contains("id")) out["id"] = json["id"];
      status = Request(agent, json).answer(out, error, ends);
    } else {
      error = "expected a JSON object on one line, found " + excerpt(request);
    }
    code = code_of(status);
  } catch (const std::bad_alloc&) {
    code = HYPGEN_NO_MEMORY;
  } catch (const std::exception& problem) {
    error = problem.what();
  }
  out["status"] = hypgen_status_name(code);
  if (error.empty() && code >= HYPGEN_FAILED) error = hypgen_status_name(code);
  if (!error.empty()) out["error"] = error;
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

bool serve(Agent& agent, const std::function<bool(std::string&)>& read,
           const std::function<bool(const std::string&)>& write) {
  bool ends = false;
  for (std::string line; !ends && read(line);) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    if (!write(answer(agent, line, ends))) return false;
  }
  return true;
}

}  // namespace hypgen
