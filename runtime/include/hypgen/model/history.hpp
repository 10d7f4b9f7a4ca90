// What the default policy and `bound lower` know of the past.
#pragma once

#include "hypgen/core/config.hpp"

namespace hypgen {

// The base of a model whose policy remembers nothing. Everywhere else a history costs memory and time only
// where kHasHistory holds.
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
