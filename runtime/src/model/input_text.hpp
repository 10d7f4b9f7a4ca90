// SPDX-License-Identifier: Apache-2.0
// What users give as text: files and JSON, which are refused where they are too large, too deep or no text.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

namespace hypgen {

/// The most bytes of a file or a request that may give so many values. Its JSON takes some twenty times
/// the memory where it is something else.
constexpr std::size_t most_input(std::size_t values) {
  constexpr std::size_t kLeast = 16'000'000, kBytesOfAValue = 64;
  return values > kLeast / kBytesOfAValue ? values * kBytesOfAValue : kLeast;
}

// How a message names that many bytes.
inline std::string megabytes(std::size_t bytes) { return std::to_string(bytes / 1'000'000) + " MB"; }

// The text of a file or of a pipe that somebody writes into. False and `error`, which does not name the file,
// where it cannot be read, has more than `most` bytes, or is no text.
bool read_input_file(const std::string& file, std::size_t most, std::string& text, std::string& error);

// What JSON text says. False and `error` where it is not valid, nested too deep, or gives a name twice in an
// object: programs differ in which of two values they take.
bool parse_json(const std::string& text, nlohmann::json& json, std::string& error);

// The beginning of a text for a message: a few words of UTF-8 on one line, whatever the text is.
std::string excerpt(const std::string& text, std::size_t most = 60);

}  // namespace hypgen
