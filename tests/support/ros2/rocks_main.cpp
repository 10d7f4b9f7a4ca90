// SPDX-License-Identifier: Apache-2.0
// Drives the node of RockSample through its states, as ROS would.
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "drive.hpp"
#include "planner_node.hpp"

namespace {

using drive::expect;
using drive::milliseconds;
using drive::next;
using rock_sample_msgs::action::Plan;
using rock_sample_msgs::msg::Decision;
using rock_sample_msgs::msg::Observation;
using rock_sample_msgs::msg::Reading;
using rock_sample_msgs::msg::Status;
using rock_sample_msgs::srv::Belief;
using rock_sample_msgs::srv::Reset;
using rock_sample_planner::PlannerNode;
using Server = rclcpp_action::Server<Plan>;
using Parameters = std::vector<rclcpp::Parameter>;

Parameters settings() {
  return {{"planner.mode", std::string("despot")},  {"planner.trials", std::int64_t{60}},
          {"planner.scenarios", std::int64_t{100}}, {"planner.particles", std::int64_t{500}},
          {"planner.memory", std::int64_t{64}},     {"planner.seed", std::int64_t{3}}};
}

// Settings under which a plan ends by its time, or because it is cancelled.
Parameters patient() {
  Parameters found = settings();
  found[1] = {"planner.time", 0.05};
  return found;
}

struct Node {
  explicit Node(const Parameters& parameters)
      : node(std::make_shared<PlannerNode>(rclcpp::NodeOptions().parameter_overrides(parameters))) {}

  void start() {
    expect(node->configure().label() == "inactive", drive::last_line(node->get_logger()));
    expect(node->activate().label() == "active", drive::last_line(node->get_logger()));
  }

  std::shared_ptr<Server> server() const { return node->test_find<Server>("~/plan"); }
  std::shared_ptr<rclcpp::TimerBase> timer() const { return node->test_find<rclcpp::TimerBase>("timer"); }

  Server::Handle send(double seconds) const {
    Plan::Goal goal;
    goal.seconds = seconds;
    return server()->test_send(goal);
  }

  Decision plan(double seconds = 0.0) const {
    const Server::Handle goal = send(seconds);
    expect(goal != nullptr, "the goal was rejected");
    const auto [state, result] = next(goal->test_results);
    expect(state == "succeeded", state + ": " + result->decision.status.text);
    return result->decision;
  }

  void see(const Observation& observation) const {
    node->test_find<rclcpp::Subscription<Observation>>("~/observation")
        ->test_receive(std::make_shared<Observation>(observation));
  }

  Status update(std::int32_t reading, std::int32_t action = Observation::LAST_DECISION) const {
    Observation observation;
    observation.action = action;
    observation.reading.code = reading;
    see(observation);
    return next(node->test_find<rclcpp_lifecycle::LifecyclePublisher<Status>>("~/belief_status")->test_sent);
  }

  Status reset(const Reset::Request& request) const {
    const auto service = node->test_find<rclcpp::Service<Reset>>("~/reset");
    service->test_call(request);
    const auto [call, response] = next(service->test_responses);
    expect(call == service->test_calls, "an answer to another call");
    return response.status;
  }

  Belief::Response belief() const {
    const auto service = node->test_find<rclcpp::Service<Belief>>("~/belief");
    service->test_call(Belief::Request());
    return next(service->test_responses).second;
  }

  std::shared_ptr<PlannerNode> node;
};

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void expect_text(const Status& status, const std::string& part) {
  expect(status.code == Status::WRONG_ARGUMENT, "status " + std::to_string(status.code));
  expect(status.text.find(part) != std::string::npos, status.text);
}

void wrong_parameters_leave_the_node_unconfigured() {
  Node node({{"planner.mode", std::string("dance")}, {"model.sure", std::int64_t{7}}});
  const auto refused = [&](const char* part) {
    expect(node.node->configure().label() == "unconfigured", "configured");
    const std::string line = drive::last_line(node.node->get_logger());
    expect(line.find(part) != std::string::npos, line);
  };
  refused("dance");
  node.node->set_parameter({"planner.mode", std::string("despot")});
  refused("sure");
  node.node->set_parameter({"model.sure", std::int64_t{1}});
  expect(node.node->configure().label() == "inactive", drive::last_line(node.node->get_logger()));
}

void an_inactive_node_takes_nothing() {
  Node node(settings());
  node.node->configure();
  expect(node.send(0.0) == nullptr, "a goal was accepted");
  node.see(Observation());
  expect(drive::last_line(node.node->get_logger()).find("not active") != std::string::npos, "no warning");
  expect_text(node.reset(Reset::Request()), "not active");
  expect_text(node.belief().status, "not active");
}

void a_goal_has_a_decision() {
  Node node(patient());
  node.start();
  const Decision decision = node.plan(0.02);
  expect(decision.action >= 0 && !decision.name.empty(), "no action");
  expect(decision.lower <= decision.upper, "bounds");
  expect(decision.status.code == Status::DEADLINE, "status " + std::to_string(decision.status.code));
  expect(decision.seconds > 0.0 && decision.seconds < 1.0, "seconds");
}

void observations_update_the_belief() {
  Node node(settings());
  node.start();
  expect_text(node.update(Reading::NOTHING), "no decision yet");
  node.plan();
  expect_text(node.update(3), "reading");
  expect_text(node.update(Reading::NOTHING, 99), "action");
  expect_text(node.update(Reading::NOTHING, -2), "action");
  expect(node.update(Reading::NOTHING, 2).code == Status::OK, "another action was done");
  expect(node.belief().json.find("rock.good[3]") != std::string::npos, node.belief().json);
  node.plan();
  Reset::Request request;
  request.episode = 4;
  expect(node.reset(request).code == Status::OK, "reset");
  expect_text(node.update(Reading::NOTHING), "no decision yet");
  request.visible_given = true;
  request.rover_x = 8;
  expect_text(node.reset(request), "rover.x");
}

void a_refused_goal_is_aborted() {
  Node node(settings());
  node.start();
  const Server::Handle goal = node.send(NAN);
  const auto [state, result] = next(goal->test_results);
  expect(state == "aborted" && result->decision.action == -1, state);
  expect_text(result->decision.status, "seconds");
}

// Cancels a goal of a minute after a while; gives its result.
void cancel_after(milliseconds wait) {
  Node node(patient());
  node.start();
  const auto begin = std::chrono::steady_clock::now();
  const Server::Handle goal = node.send(60.0);
  std::this_thread::sleep_for(wait);
  expect(node.server()->test_cancel(goal), "cancelling was refused");
  const auto [state, result] = next(goal->test_results, node.timer());
  expect(seconds_since(begin) < 10.0, "it went on");
  expect(state == "canceled" && result->decision.action >= 0, state);
  node.timer()->test_fire();
  expect(node.timer()->is_canceled(), "the timer goes on");
  node.plan(0.02);
}

void one_goal_at_a_time_and_observations_wait() {
  Node node(patient());
  node.start();
  node.plan(0.02);
  const Server::Handle first = node.send(0.5);
  expect(node.send(0.1) == nullptr, "a second goal was accepted");
  expect(node.update(Reading::NOTHING, 2).code == Status::OK, "update");
  expect(first->test_results.take(milliseconds(0)).has_value(), "the update did not wait");
  node.plan(0.02);
}

void deactivating_ends_a_plan() {
  Node node(patient());
  node.start();
  const auto begin = std::chrono::steady_clock::now();
  const Server::Handle goal = node.send(60.0);
  expect(node.node->deactivate().label() == "inactive", "not deactivated");
  expect(seconds_since(begin) < 10.0, "it went on");
  expect(goal->test_results.take(milliseconds(0))->first == "succeeded", "no result");
  expect(node.send(0.0) == nullptr, "a goal was accepted");
  expect(node.node->activate().label() == "active", "not activated again");
  node.plan(0.02);
}

void cleaning_up_releases_all() {
  Node node(settings());
  node.start();
  node.plan();
  node.node->deactivate();
  expect(node.node->cleanup().label() == "unconfigured", "not cleaned up");
  expect(node.server() == nullptr && node.timer() == nullptr, "a server is left");
  node.start();
  node.plan();
  expect(node.node->shutdown().label() == "finalized", "not shut down");
  expect(node.server() == nullptr, "a server is left");
}

void destroying_ends_a_plan() {
  Node node(patient());
  node.start();
  const auto begin = std::chrono::steady_clock::now();
  const Server::Handle goal = node.send(60.0);
  node.node.reset();
  expect(seconds_since(begin) < 10.0, "it went on");
}

// Prints what a few steps decide, for the test to compare.
void decisions() {
  Parameters parameters = settings();
  parameters.emplace_back("model.start_row", std::int64_t{1});
  Node node(parameters);
  node.start();
  Reset::Request request;
  request.episode = 2;
  node.reset(request);
  for (int step = 0; step < 5; ++step) {
    const Decision found = node.plan();
    std::printf("decision %d %.17g %.17g\n", found.action, found.lower, found.upper);
    const bool checks = found.name.rfind("check", 0) == 0;
    expect(node.update(checks ? Reading::LOOKS_BAD : Reading::NOTHING).code == Status::OK, "update");
  }
}

}  // namespace

int main() {
  return drive::run({
      {"wrong parameters leave the node unconfigured", wrong_parameters_leave_the_node_unconfigured},
      {"an inactive node takes nothing", an_inactive_node_takes_nothing},
      {"a goal has a decision", a_goal_has_a_decision},
      {"observations update the belief", observations_update_the_belief},
      {"a refused goal is aborted", a_refused_goal_is_aborted},
      {"a cancelled goal has a decision", [] { cancel_after(milliseconds(50)); }},
      {"a goal is cancelled before it has begun", [] { cancel_after(milliseconds(0)); }},
      {"one goal at a time, and observations wait", one_goal_at_a_time_and_observations_wait},
      {"deactivating ends a plan", deactivating_ends_a_plan},
      {"cleaning up releases all", cleaning_up_releases_all},
      {"destroying ends a plan", destroying_ends_a_plan},
      {"decisions", decisions},
  });
}
