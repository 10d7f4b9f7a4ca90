// SPDX-License-Identifier: Apache-2.0
// As much of rclcpp as a generated node uses, for tests without ROS: what the node gives is kept for the test, and
// the test calls the node's callbacks as an executor of one thread would. Members that begin with `test_` are the
// test's.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

struct rmw_request_id_t {
  std::int64_t sequence_number = 0;
};

namespace rclcpp {

// Values that arrive from any thread, for one that waits for them.
template <class T>
class Mailbox {
 public:
  void put(T value) {
    const std::lock_guard<std::mutex> lock(mutex_);
    values_.push_back(std::move(value));
    changed_.notify_all();
  }

  std::optional<T> take(std::chrono::milliseconds longest) {
    std::unique_lock<std::mutex> lock(mutex_);
    if (!changed_.wait_for(lock, longest, [this] { return !values_.empty(); })) return std::nullopt;
    T value = std::move(values_.front());
    values_.erase(values_.begin());
    return value;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<T> values_;
};

struct Logger {
  std::shared_ptr<Mailbox<std::string>> test_lines = std::make_shared<Mailbox<std::string>>();
};

template <class... Arguments>
void test_log(const Logger& logger, const char* format, Arguments... arguments) {
  char line[1000];
  std::snprintf(line, sizeof line, format, arguments...);
  logger.test_lines->put(line);
}

#define RCLCPP_INFO(logger, ...) rclcpp::test_log(logger, __VA_ARGS__)
#define RCLCPP_WARN(logger, ...) rclcpp::test_log(logger, __VA_ARGS__)
#define RCLCPP_ERROR(logger, ...) rclcpp::test_log(logger, __VA_ARGS__)

struct KeepLast {
  explicit KeepLast(std::size_t) {}
};

struct QoS {
  explicit QoS(const KeepLast&) {}
  QoS& reliable() { return *this; }
};

enum ParameterType : std::uint8_t {
  PARAMETER_NOT_SET,
  PARAMETER_BOOL,
  PARAMETER_INTEGER,
  PARAMETER_DOUBLE,
  PARAMETER_STRING,
  PARAMETER_BYTE_ARRAY,
  PARAMETER_BOOL_ARRAY,
  PARAMETER_INTEGER_ARRAY,
  PARAMETER_DOUBLE_ARRAY,
  PARAMETER_STRING_ARRAY
};

class ParameterValue {
 public:
  ParameterValue() = default;
  template <class T>
  explicit ParameterValue(const T& value) : value_(value) {}

  ParameterType get_type() const { return static_cast<ParameterType>(value_.index()); }

  template <class T>
  const T& get() const {
    return std::get<T>(value_);  // throws where the type is another one, as rclcpp does
  }

 private:
  using Bytes = std::vector<std::uint8_t>;
  std::variant<std::monostate, bool, std::int64_t, double, std::string, Bytes, std::vector<bool>,
               std::vector<std::int64_t>, std::vector<double>, std::vector<std::string>>
      value_;
};

class Parameter {
 public:
  Parameter(std::string name, ParameterValue value) : name_(std::move(name)), value_(std::move(value)) {}
  template <class T>
  Parameter(std::string name, const T& value) : Parameter(std::move(name), ParameterValue(value)) {}

  const std::string& get_name() const { return name_; }
  const ParameterValue& get_parameter_value() const { return value_; }
  ParameterType get_type() const { return value_.get_type(); }
  bool as_bool() const { return value_.get<bool>(); }
  std::int64_t as_int() const { return value_.get<std::int64_t>(); }
  double as_double() const { return value_.get<double>(); }
  const std::string& as_string() const { return value_.get<std::string>(); }
  const std::vector<bool>& as_bool_array() const { return value_.get<std::vector<bool>>(); }
  const std::vector<std::int64_t>& as_integer_array() const {
    return value_.get<std::vector<std::int64_t>>();
  }
  const std::vector<double>& as_double_array() const { return value_.get<std::vector<double>>(); }
  const std::vector<std::string>& as_string_array() const { return value_.get<std::vector<std::string>>(); }

 private:
  std::string name_;
  ParameterValue value_;
};

class NodeOptions {
 public:
  NodeOptions& parameter_overrides(const std::vector<Parameter>& overrides) {
    overrides_ = overrides;
    return *this;
  }
  const std::vector<Parameter>& parameter_overrides() const { return overrides_; }

 private:
  std::vector<Parameter> overrides_;
};

template <class Message>
struct Subscription {
  using SharedPtr = std::shared_ptr<Subscription>;
  std::function<void(std::shared_ptr<const Message>)> test_receive;
};

template <class ServiceT>
class Service : public std::enable_shared_from_this<Service<ServiceT>> {
 public:
  using SharedPtr = std::shared_ptr<Service>;
  using Response = typename ServiceT::Response;

  void send_response(rmw_request_id_t& header, Response& response) {
    test_responses.put({header.sequence_number, response});
  }

  void test_call(const typename ServiceT::Request& request) {
    auto header = std::make_shared<rmw_request_id_t>();
    header->sequence_number = ++test_calls;
    test_receive(this->shared_from_this(), header, std::make_shared<typename ServiceT::Request>(request));
  }

  // A callback of this kind answers by send_response, whenever it likes.
  std::function<void(std::shared_ptr<Service>, std::shared_ptr<rmw_request_id_t>,
                     std::shared_ptr<typename ServiceT::Request>)>
      test_receive;
  std::int64_t test_calls = 0;
  Mailbox<std::pair<std::int64_t, Response>> test_responses;
};

class TimerBase {
 public:
  using SharedPtr = std::shared_ptr<TimerBase>;
  explicit TimerBase(std::function<void()> callback) : callback_(std::move(callback)) {}
  void cancel() { is_canceled_ = true; }
  void reset() { is_canceled_ = false; }
  bool is_canceled() const { return is_canceled_; }
  void test_fire() {
    if (!is_canceled_) callback_();
  }

 private:
  std::function<void()> callback_;
  bool is_canceled_ = false;
};

inline void init(int, char**) {}
inline void shutdown() {}
template <class Node>
void spin(const Node&) {}

}  // namespace rclcpp
