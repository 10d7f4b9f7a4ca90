// The share of a step that one warp of a block takes.
#pragma once

namespace hypgen {

struct Part {
  int rank;   // of the warp
  int count;  // of warps
};

}  // namespace hypgen
