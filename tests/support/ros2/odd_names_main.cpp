// SPDX-License-Identifier: Apache-2.0
// Drives the node of a model whose start has to be said, with values of every kind.
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "drive.hpp"
#include "planner_node.hpp"

namespace {

using drive::expect;
using drive::next;
using model_2_odd_names_msgs::action::Plan;
using model_2_odd_names_msgs::msg::NullKind;
using model_2_odd_names_msgs::msg::NullKind2;
using model_2_odd_names_msgs::msg::Observation;
using model_2_odd_names_msgs::msg::Pos;
using model_2_odd_names_msgs::msg::Status;
using model_2_odd_names_msgs::srv::Reset;
using Node = model_2_odd_names_planner::PlannerNode;

const std::vector<rclcpp::Parameter> kSettings = {{"planner.mode", std::string("despot")},
                                                  {"planner.trials", std::int64_t{20}},
                                                  {"planner.memory", std::int64_t{64}},
                                                  {"warm_up", std::int64_t{0}}};

std::shared_ptr<Node> made(double rate) {
  std::vector<rclcpp::Parameter> parameters = kSettings;
  parameters.emplace_back("model.rate", rate);
  return std::make_shared<Node>(rclcpp::NodeOptions().parameter_overrides(parameters));
}

Pos pos(std::int32_t x, std::int32_t kind, bool up) {
  Pos value;
  value.class_value = x;
  value.kind.code = kind;
  value.up = up;
  return value;
}

Reset::Request start() {
  Reset::Request request;
  request.robot_class = pos(2, NullKind2::AT + 3, true);
  request.robot_class_2 = -1;
  request.robot = {true, false};
  request.robot_far = 0.25F;
  return request;
}

Status reset(const Node& node, const Reset::Request& request) {
  const auto service = node.test_find<rclcpp::Service<Reset>>("~/reset");
  service->test_call(request);
  return next(service->test_responses).second.status;
}

Status update(const Node& node, const Observation& observation) {
  node.test_find<rclcpp::Subscription<Observation>>("~/observation")
      ->test_receive(std::make_shared<Observation>(observation));
  return next(node.test_find<rclcpp_lifecycle::LifecyclePublisher<Status>>("~/belief_status")->test_sent);
}

std::pair<std::string, std::shared_ptr<Plan::Result>> plan(const Node& node) {
  const auto goal = node.test_find<rclcpp_action::Server<Plan>>("~/plan")->test_send(Plan::Goal());
  expect(goal != nullptr, "rejected");
  return next(goal->test_results);
}

void expect_text(const Status& status, const std::string& part) {
  expect(status.code == Status::WRONG_ARGUMENT, "status " + std::to_string(status.code));
  expect(status.text.find(part) != std::string::npos, status.text);
}

void a_param_without_a_value_has_to_be_given() {
  const auto node = std::make_shared<Node>(rclcpp::NodeOptions().parameter_overrides(kSettings));
  expect(node->configure().label() == "unconfigured", "configured");
  const std::string line = drive::last_line(node->get_logger());
  expect(line.find("rate") != std::string::npos, line);
  node->set_parameter({"model.rate", 0.5});
  expect(node->configure().label() == "inactive", drive::last_line(node->get_logger()));
}

void a_drawn_start_has_to_be_said() {
  const auto node = made(0.5);
  node->configure();
  expect(node->activate().label() == "active", drive::last_line(node->get_logger()));
  const auto [state, result] = plan(*node);
  expect(state == "aborted" && result->decision.status.code == Status::WRONG_ARGUMENT, state);
  Reset::Request request = start();
  request.visible_given = false;
  expect_text(reset(*node, request), "say what it is");
  request = start();
  request.robot_class.class_value = 3;
  expect_text(reset(*node, request), "pos.class: expected -1 to 2, found 3");
  request = start();
  request.robot_class.kind.code = 7;
  expect_text(reset(*node, request), "pos.Kind: expected 0 to 6, found 7");
  request = start();
  request.robot_class_2 = 5;
  expect_text(reset(*node, request), "robot.class_");
  expect(reset(*node, start()).code == Status::OK, "reset");
  expect(plan(*node).first == "succeeded", "no plan");
}

void values_arrive_as_they_are() {
  const auto node = made(0.5);
  node->configure();
  node->activate();
  expect(reset(*node, start()).code == Status::OK, "reset");
  Observation observation;
  observation.robot_kind.code = NullKind::B;
  observation.robot_class = pos(-1, NullKind2::LOOKS_GOOD, false);
  observation.robot_far = -1.5F;
  observation.action_2 = {true, false, false, true, true, true, false, false};
  for (int step = 0; step < 3; ++step) {
    const auto [state, result] = plan(*node);
    expect(state == "succeeded" && result->decision.action >= 0, state);
    expect(update(*node, observation).code == Status::OK, "update");
  }
  observation.robot_class.kind.code = -1;
  expect_text(update(*node, observation), "pos.Kind");
  observation.robot_class.kind.code = 0;
  observation.robot_far = NAN;
  plan(*node);
  expect(update(*node, observation).code != Status::OK, "no number was seen");
}

}  // namespace

int main() {
  return drive::run({
      {"a param without a value has to be given", a_param_without_a_value_has_to_be_given},
      {"a drawn start has to be said", a_drawn_start_has_to_be_said},
      {"values arrive as they are", values_arrive_as_they_are},
  });
}
