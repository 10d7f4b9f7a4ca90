// SPDX-License-Identifier: Apache-2.0
// The base of a model whose default policy remembers nothing of the past.
#pragma once

#include "hypgen/core/config.hpp"

namespace hypgen {

// A History of no bytes. The runtime spends memory and time on histories only where kHasHistory is true.
struct NoHistory {
  struct History {};
  static constexpr bool kHasHistory = false;

  template <class... Parts>
  HYPGEN_FN static void init_history(const Parts&...) {}
  template <class... Parts>
  HYPGEN_FN static void advance_history(const Parts&...) {}
  template <class... Parts>
  HYPGEN_FN static void roll_history(const Parts&...) {}
};

}  // namespace hypgen
