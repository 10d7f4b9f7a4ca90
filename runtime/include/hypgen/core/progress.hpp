// SPDX-License-Identifier: Apache-2.0
// A progress bar for people who wait.
#pragma once

#include <cstdint>

namespace hypgen {

// Draws over episodes on standard error, if that is a terminal.
class Progress {
 public:
  Progress(std::uint64_t episodes, int steps, bool wanted);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(std::uint64_t episode, int step, double mean_return);

 private:
  std::uint64_t episodes_;
  int steps_;
  bool shown_;
};

}  // namespace hypgen
