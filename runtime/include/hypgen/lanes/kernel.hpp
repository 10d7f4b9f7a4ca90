// SPDX-License-Identifier: Apache-2.0
// What the search asks of a model's lanes: plain data, as lanes are compiled once for each kind of processor.
//
// Such a unit is compiled with flags of its own and a name of its own for the namespace hypgen, so that the
// linker never takes its code for a processor that lacks the instructions. This namespace has one name in all.
#pragma once

#include <cstddef>
#include <cstdint>

namespace hypgen_lanes {

// Rollouts of one leaf's scenarios: item i starts in states[i].
struct Rollouts {
  std::size_t count;
  const void* params;
  const void* fixed;               // of all scenarios of the search, by index
  const void* states;              // of each item
  const void* const* histories;    // of each item; null where the model keeps none
  const std::uint32_t* scenarios;  // of each item, an index into `fixed`
  const std::uint32_t* numbers;    // of each item, by which it draws
  std::uint32_t first_number;      // is added to these
  std::uint32_t key0;
  std::uint32_t key1;
  int depth;        // of the first step
  int depth_limit;  // more than `depth`
  bool at_horizon;
  const float* discounts;  // by steps taken
  float* lowers;           // what each item earns
  bool met_nan;            // becomes true for a model error
  // Counts steps; true: time is over, and nothing of the results is known.
  bool (*count_steps)(void* clock, std::uint64_t steps);
  void* clock;
};

// A model's lanes, compiled for one kind of processor. A constant without code: other processors read it.
struct Kernel {
  const char* name;  // avx2 or avx512
  int lanes;
  void (*roll)(Rollouts& work);
};

}  // namespace hypgen_lanes

// The kernel of a model for the kind of processor that HYPGEN_LANES names, and that name.
#define HYPGEN_LANES_JOINED(model, kind) kernel_##model##_##kind
#define HYPGEN_LANES_KERNEL_OF(model, kind) HYPGEN_LANES_JOINED(model, kind)
#define HYPGEN_LANES_KERNEL(model) HYPGEN_LANES_KERNEL_OF(model, HYPGEN_LANES)
#define HYPGEN_LANES_TEXT_OF(kind) #kind
#define HYPGEN_LANES_TEXT(kind) HYPGEN_LANES_TEXT_OF(kind)
