// Scans of contiguous numbers, written so that compilers turn them into vector instructions.
#pragma once

#include <cstddef>

namespace hypgen {

// The largest of `count` numbers, at least one and none of them NaN.
inline double largest(const double* numbers, std::size_t count) {
  constexpr std::size_t kLanes = 16;
  double result = numbers[0];
  std::size_t i = 0;
  if (count >= kLanes) {
    double lanes[kLanes];
    for (std::size_t j = 0; j < kLanes; ++j) lanes[j] = numbers[j];
    for (i = kLanes; i + kLanes <= count; i += kLanes) {
      for (std::size_t j = 0; j < kLanes; ++j) {
        lanes[j] = lanes[j] < numbers[i + j] ? numbers[i + j] : lanes[j];
      }
    }
    for (const double lane : lanes) result = result < lane ? lane : result;
  }
  for (; i < count; ++i) result = result < numbers[i] ? numbers[i] : result;
  return result;
}

// Where the largest of them stands, the first of equals.
inline std::size_t first_largest(const double* numbers, std::size_t count) {
  constexpr std::size_t kBlock = 16;
  const double wanted = largest(numbers, count);
  std::size_t i = 0;
  for (; i + kBlock <= count; i += kBlock) {
    bool found = false;
    for (std::size_t j = 0; j < kBlock; ++j) found |= numbers[i + j] == wanted;
    if (found) break;
  }
  while (numbers[i] != wanted) ++i;
  return i;
}

}  // namespace hypgen
