// SPDX-License-Identifier: Apache-2.0
// Command lines as tables of options.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <type_traits>
#include <vector>

#include "hypgen/model/descriptor.hpp"

namespace hypgen {

constexpr std::uint64_t kMillion = 1000000;
constexpr std::size_t kMostThreads = 1024;

// An option: what its value must be, and where it goes. Without a metavar it is a switch.
struct Option {
  const char* name;
  const char* metavar;
  const char* help;
  std::string expected;
  std::function<bool(const std::string&)> take;
};

bool read_double(const std::string& text, double low, double high, double& out);
bool read_integer(const std::string& text, std::uint64_t low, std::uint64_t high, std::uint64_t& out);
template <class T>
bool read_integer(const std::string& text, std::uint64_t low, std::uint64_t high, T& out) {
  std::uint64_t value = 0;
  if (!read_integer(text, low, high, value)) return false;
  out = static_cast<T>(value);
  return true;
}

std::string integer_range(std::uint64_t low, std::uint64_t high);

Option number(const char* name, const char* metavar, const char* help, double low, double high, double& out);
template <class T>
Option integer(const char* name, const char* metavar, const char* help, std::uint64_t low, std::uint64_t high,
               T& out) {
  return {name, metavar, help, integer_range(low, high),
          [=, &out](const std::string& text) { return read_integer(text, low, high, out); }};
}
Option file(const char* name, const char* help, std::string& out);
Option toggle(const char* name, const char* help, bool& out);
Option mebibytes(const char* name, const char* help, std::size_t& bytes);
Option belief_kind(BeliefKind& kind);
Option particles(std::size_t& count);

// Reads a command line, and gives the names of the options on it; false and `error` on an unknown option or a
// bad value.
bool read_options(const std::vector<Option>& table, int argc, const char* const* argv,
                  std::vector<std::string>& given, std::string& error);

// What --help says of the options, and of the model's params.
std::string help_lines(const std::vector<Option>& table);
std::string help_params(const ModelDescriptor& model);

// What --version prints.
std::string version_text(const ModelDescriptor& model);

}  // namespace hypgen
