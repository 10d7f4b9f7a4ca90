// SPDX-License-Identifier: Apache-2.0
// A test of JSON text before it is read: the parts of a deep value call each other until the stack is full.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

namespace hypgen {

/// Whether brackets outside of strings are nested deeper than those of any array.
inline bool is_too_deep(const std::string& json) {
  constexpr int kMostDepth = 100;
  int depth = 0, most = 0;
  bool is_text = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (c == '"') is_text = !is_text;
    if (is_text) {
      i += c == '\\' ? 1 : 0;
      continue;
    }
    depth += c == '[' || c == '{' ? 1 : c == ']' || c == '}' ? -1 : 0;
    most = std::max(most, depth);
  }
  return most > kMostDepth;
}

}  // namespace hypgen
