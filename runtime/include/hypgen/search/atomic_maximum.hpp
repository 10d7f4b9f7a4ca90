// SPDX-License-Identifier: Apache-2.0
// Scans of contiguous numbers that other threads may change meanwhile.
#pragma once

#include <atomic>
#include <cstdint>

namespace hypgen {

struct Largest {
  double value;
  std::uint32_t place;  // of the first of equals
};

// The largest of `count` numbers, at least one and none of them NaN.
inline Largest largest(const std::atomic<double>* numbers, std::uint32_t count) {
  constexpr std::uint32_t kLanes = 4;  // as one comparison need not wait for the one before
  while (true) {
    double lanes[kLanes];
    for (double& lane : lanes) lane = numbers[0].load();
    std::uint32_t i = 0;
    for (; i + kLanes <= count; i += kLanes) {
      for (std::uint32_t j = 0; j < kLanes; ++j) {
        const double number = numbers[i + j].load();
        lanes[j] = lanes[j] < number ? number : lanes[j];
      }
    }
    double value = lanes[0];
    for (const double lane : lanes) value = value < lane ? lane : value;
    for (; i < count; ++i) {
      const double number = numbers[i].load();
      value = value < number ? number : value;
    }
    for (std::uint32_t place = 0; place < count; ++place) {
      if (numbers[place].load() == value) return {value, place};
    }
    // Another thread has lowered the largest since: scan again.
  }
}

}  // namespace hypgen
