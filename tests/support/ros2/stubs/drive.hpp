// SPDX-License-Identifier: Apache-2.0
// What programs that drive a generated node share: checks, and waiting for what the node gives.
#pragma once

#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "rclcpp/rclcpp.hpp"

namespace drive {

using std::chrono::milliseconds;
constexpr milliseconds kSoon{10000};  // that what should happen at once may take on a busy machine

inline void expect(bool holds, const std::string& what) {
  if (!holds) throw std::runtime_error(what);
}

// The next value, which has to come.
template <class T>
T next(rclcpp::Mailbox<T>& mailbox, milliseconds longest = kSoon) {
  std::optional<T> value = mailbox.take(longest);
  expect(value.has_value(), "nothing came");
  return *value;
}

// The same while a timer of the node fires, as in an executor.
template <class T>
T next(rclcpp::Mailbox<T>& mailbox, const std::shared_ptr<rclcpp::TimerBase>& timer) {
  for (int i = 0; i < kSoon.count(); ++i) {
    timer->test_fire();
    if (std::optional<T> value = mailbox.take(milliseconds(1))) return *value;
  }
  throw std::runtime_error("nothing came");
}

inline std::string last_line(const rclcpp::Logger& logger) {
  std::string line;
  while (const std::optional<std::string> found = logger.test_lines->take(milliseconds(0))) line = *found;
  return line;
}

struct Check {
  const char* name;
  std::function<void()> run;
};

// Prints a line for each check; gives how many failed.
inline int run(const std::vector<Check>& checks) {
  int failed = 0;
  for (const Check& check : checks) {
    std::string outcome = "ok";
    try {
      check.run();
    } catch (const std::exception& problem) {
      outcome = problem.what();
      ++failed;
    }
    std::printf("%s: %s\n", check.name, outcome.c_str());
    std::fflush(stdout);
  }
  return failed;
}

}  // namespace drive
