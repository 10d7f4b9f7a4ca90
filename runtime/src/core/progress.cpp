// SPDX-License-Identifier: Apache-2.0
#include "hypgen/core/progress.hpp"

#include <unistd.h>

#include <cstdio>
#include <string>

namespace hypgen {

Progress::Progress(std::uint64_t episodes, int steps, bool wanted)
    : episodes_(episodes), steps_(steps), shown_(wanted && isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  if (shown_) std::fprintf(stderr, "\r\033[K");
}

void Progress::update(std::uint64_t episode, int step, double mean_return) {
  if (!shown_) return;
  constexpr std::uint64_t kWidth = 30;
  const std::string bar(static_cast<std::size_t>(kWidth * episode / episodes_), '#');
  std::fprintf(stderr, "\r\033[K[%-30s] episode %llu of %llu, step %d of at most %d, mean return %.3f",
               bar.c_str(), static_cast<unsigned long long>(episode + 1),
               static_cast<unsigned long long>(episodes_), step + 1, steps_, mean_return);
  std::fflush(stderr);
}

}  // namespace hypgen
