// SPDX-License-Identifier: Apache-2.0
// As much of an action server as a generated node uses, with the state machine of goals.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>

#include "rclcpp/rclcpp.hpp"

namespace rclcpp_action {

using GoalUUID = std::array<std::uint8_t, 16>;

enum class GoalResponse : std::int8_t { REJECT = 1, ACCEPT_AND_EXECUTE = 2, ACCEPT_AND_DEFER = 3 };
enum class CancelResponse : std::int8_t { REJECT = 1, ACCEPT = 2 };

template <class Action>
class ServerGoalHandle {
 public:
  using Result = std::shared_ptr<typename Action::Result>;

  ServerGoalHandle(GoalUUID id, std::shared_ptr<const typename Action::Goal> goal)
      : id_(id), goal_(std::move(goal)) {}

  const GoalUUID& get_goal_id() const { return id_; }
  std::shared_ptr<const typename Action::Goal> get_goal() const { return goal_; }
  bool is_canceling() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return state_ == "canceling";
  }
  void succeed(Result result) { end("succeeded", result, true); }
  void abort(Result result) { end("aborted", result, true); }
  void canceled(Result result) { end("canceled", result, false); }

  // False if the goal has ended.
  bool test_set_canceling() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (state_ != "executing") return false;
    state_ = "canceling";
    return true;
  }

  rclcpp::Mailbox<std::pair<std::string, Result>> test_results;  // the last state, and the result

 private:
  void end(const std::string& state, Result result, bool from_executing) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (state_ != "canceling" && !(from_executing && state_ == "executing"))
      throw std::runtime_error("a goal cannot go from " + state_ + " to " + state);
    state_ = state;
    test_results.put({state, std::move(result)});
  }

  mutable std::mutex mutex_;
  std::string state_ = "executing";
  GoalUUID id_;
  std::shared_ptr<const typename Action::Goal> goal_;
};

template <class Action>
class Server {
 public:
  using SharedPtr = std::shared_ptr<Server>;
  using Handle = std::shared_ptr<ServerGoalHandle<Action>>;
  using Goal = std::shared_ptr<const typename Action::Goal>;
  using GoalCallback = std::function<GoalResponse(const GoalUUID&, Goal)>;
  using CancelCallback = std::function<CancelResponse(Handle)>;
  using AcceptedCallback = std::function<void(Handle)>;

  Server(GoalCallback goal, CancelCallback cancel, AcceptedCallback accepted)
      : handle_goal_(std::move(goal)),
        handle_cancel_(std::move(cancel)),
        handle_accepted_(std::move(accepted)) {}

  // Null if the goal is rejected.
  Handle test_send(const typename Action::Goal& goal) {
    GoalUUID id{};
    id[0] = ++goals_;
    const auto sent = std::make_shared<typename Action::Goal>(goal);
    if (handle_goal_(id, sent) == GoalResponse::REJECT) return nullptr;
    const auto handle = std::make_shared<ServerGoalHandle<Action>>(id, sent);
    handle_accepted_(handle);
    return handle;
  }

  // As rclcpp does it: the state changes after the callback, and not if the goal has ended by then.
  bool test_cancel(const Handle& handle) {
    return handle_cancel_(handle) == CancelResponse::ACCEPT && handle->test_set_canceling();
  }

 private:
  GoalCallback handle_goal_;
  CancelCallback handle_cancel_;
  AcceptedCallback handle_accepted_;
  std::uint8_t goals_ = 0;
};

template <class Action, class Node>
typename Server<Action>::SharedPtr create_server(Node node, const std::string& name,
                                                 typename Server<Action>::GoalCallback goal,
                                                 typename Server<Action>::CancelCallback cancel,
                                                 typename Server<Action>::AcceptedCallback accepted) {
  return node->test_add(name, std::make_shared<Server<Action>>(goal, cancel, accepted));
}

}  // namespace rclcpp_action
