// SPDX-License-Identifier: Apache-2.0
// As much of rclcpp_lifecycle as a generated node uses: the states, and what is created by name.
#pragma once

#include <any>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "rcl_interfaces/msg/parameter_descriptor.hpp"
#include "rclcpp/rclcpp.hpp"

namespace rclcpp_lifecycle {

class State {
 public:
  explicit State(std::string label = "unconfigured") : label_(std::move(label)) {}
  std::string label() const { return label_; }

 private:
  std::string label_;
};

namespace node_interfaces {

class LifecycleNodeInterface {
 public:
  enum class CallbackReturn { SUCCESS, FAILURE, ERROR };

  virtual ~LifecycleNodeInterface() = default;
  virtual CallbackReturn on_configure(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_cleanup(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_shutdown(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_activate(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_deactivate(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_error(const State&) { return CallbackReturn::FAILURE; }
};

}  // namespace node_interfaces

// Messages of a publisher that is not activated are lost.
template <class Message>
class LifecyclePublisher {
 public:
  using SharedPtr = std::shared_ptr<LifecyclePublisher>;
  explicit LifecyclePublisher(std::shared_ptr<const bool> is_active) : is_active_(std::move(is_active)) {}
  void publish(const Message& message) {
    if (*is_active_) test_sent.put(message);
  }

  rclcpp::Mailbox<Message> test_sent;

 private:
  std::shared_ptr<const bool> is_active_;
};

class LifecycleNode : public node_interfaces::LifecycleNodeInterface,
                      public std::enable_shared_from_this<LifecycleNode> {
 public:
  explicit LifecycleNode(const std::string& name, const rclcpp::NodeOptions& options = rclcpp::NodeOptions())
      : test_name(name) {
    for (const rclcpp::Parameter& given : options.parameter_overrides())
      overrides_.emplace(given.get_name(), given.get_parameter_value());
  }

  CallbackReturn on_activate(const State&) override {
    *is_active_ = true;
    return CallbackReturn::SUCCESS;
  }
  CallbackReturn on_deactivate(const State&) override {
    *is_active_ = false;
    return CallbackReturn::SUCCESS;
  }

  const State& configure() { return change("unconfigured", "inactive", &LifecycleNode::on_configure); }
  const State& activate() { return change("inactive", "active", &LifecycleNode::on_activate); }
  const State& deactivate() { return change("active", "inactive", &LifecycleNode::on_deactivate); }
  const State& cleanup() { return change("inactive", "unconfigured", &LifecycleNode::on_cleanup); }
  const State& shutdown() { return change(state_.label(), "finalized", &LifecycleNode::on_shutdown); }

  rclcpp::Logger get_logger() const { return logger_; }
  std::shared_ptr<LifecycleNode> get_node_base_interface() { return shared_from_this(); }

  const rclcpp::ParameterValue& declare_parameter(
      const std::string& name, const rclcpp::ParameterValue& value,
      const rcl_interfaces::msg::ParameterDescriptor& descriptor) {
    const auto given = overrides_.find(name);
    const rclcpp::ParameterValue& first = given == overrides_.end() ? value : given->second;
    if (!descriptor.dynamic_typing && (first.get_type() != value.get_type() || !value.get_type()))
      throw std::invalid_argument(name + " has another type");
    const auto [found, is_new] = parameters_.emplace(name, first);
    if (!is_new) throw std::invalid_argument(name + " is declared already");
    return found->second;
  }

  rclcpp::Parameter get_parameter(const std::string& name) const { return {name, parameters_.at(name)}; }
  void set_parameter(const rclcpp::Parameter& parameter) {
    parameters_.at(parameter.get_name()) = parameter.get_parameter_value();
  }

  template <class Message>
  std::shared_ptr<LifecyclePublisher<Message>> create_publisher(const std::string& name, const rclcpp::QoS&) {
    return test_add(name, std::make_shared<LifecyclePublisher<Message>>(is_active_));
  }

  template <class Message, class Callback>
  std::shared_ptr<rclcpp::Subscription<Message>> create_subscription(const std::string& name,
                                                                     const rclcpp::QoS&,
                                                                     Callback&& callback) {
    auto made = std::make_shared<rclcpp::Subscription<Message>>();
    made->test_receive = std::forward<Callback>(callback);
    return test_add(name, made);
  }

  template <class ServiceT, class Callback>
  std::shared_ptr<rclcpp::Service<ServiceT>> create_service(const std::string& name, Callback&& callback) {
    auto made = std::make_shared<rclcpp::Service<ServiceT>>();
    made->test_receive = std::forward<Callback>(callback);
    return test_add(name, made);
  }

  template <class Duration, class Callback>
  std::shared_ptr<rclcpp::TimerBase> create_wall_timer(Duration, Callback callback) {
    return test_add("timer", std::make_shared<rclcpp::TimerBase>(callback));
  }

  // What was created by a name and is alive; null otherwise.
  template <class T>
  std::shared_ptr<T> test_find(const std::string& name) const {
    const auto found = made_.find(name);
    return found == made_.end() ? nullptr : std::any_cast<std::weak_ptr<T>>(found->second).lock();
  }

  template <class T>
  std::shared_ptr<T> test_add(const std::string& name, std::shared_ptr<T> made) {
    made_[name] = std::weak_ptr<T>(made);
    return made;
  }

  const std::string test_name;

 private:
  // Goes from one state to another if `callback` says so; an exception is an error, as in rclcpp.
  const State& change(const std::string& from, const std::string& to,
                      CallbackReturn (LifecycleNode::*callback)(const State&)) {
    if (state_.label() != from) throw std::runtime_error("no such transition from " + state_.label());
    CallbackReturn result = CallbackReturn::ERROR;
    try {
      result = (this->*callback)(state_);
    } catch (const std::exception& problem) {
      RCLCPP_ERROR(logger_, "%s", problem.what());
    }
    if (result == CallbackReturn::SUCCESS) state_ = State(to);
    if (result == CallbackReturn::ERROR)
      state_ = State(on_error(state_) == CallbackReturn::SUCCESS ? "unconfigured" : "finalized");
    return state_;
  }

  State state_;
  rclcpp::Logger logger_;
  std::shared_ptr<bool> is_active_ = std::make_shared<bool>(false);
  std::map<std::string, rclcpp::ParameterValue> overrides_;
  std::map<std::string, rclcpp::ParameterValue> parameters_;
  std::map<std::string, std::any> made_;
};

}  // namespace rclcpp_lifecycle
