// SPDX-License-Identifier: Apache-2.0
// Threads that share numbered jobs.
#pragma once

#include <cstddef>
#include <functional>

namespace hypgen {

class Workers {
 public:
  using Job = std::function<void(std::size_t number)>;

  virtual ~Workers() = default;

  // Does the jobs 0 .. count - 1, in any order and some at the same time. Returns when all are done.
  virtual void share(std::size_t count, const Job& job) = 0;
};

// Does the jobs on the caller's thread alone where `workers` is null. A function object that held all that a job
// refers to would be allocated, so it holds the job's address.
template <class Do>
void share(Workers* workers, std::size_t count, const Do& job) {
  if (workers != nullptr && count > 1) return workers->share(count, std::cref(job));
  for (std::size_t number = 0; number < count; ++number) job(number);
}

}  // namespace hypgen
