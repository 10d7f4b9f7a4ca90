// SPDX-License-Identifier: Apache-2.0
#include "report_text.hpp"

#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace hypgen::exact {

std::string format(const char* pattern, ...) {
  char text[256];
  std::va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

std::string row(const std::string& name, const std::string& value) {
  const std::size_t width = 16;
  return name + std::string(name.size() < width ? width - name.size() : 1, ' ') + value + "\n";
}

std::string outwards(double lower, double upper) {
  const auto unit = [](double bound) {
    return bound == 0.0 ? 1.0 : std::pow(10.0, std::floor(std::log10(std::abs(bound))) - 5.0);
  };
  return format("%.6g .. %.6g", std::floor(lower / unit(lower)) * unit(lower),
                std::ceil(upper / unit(upper)) * unit(upper));
}

}  // namespace hypgen::exact
