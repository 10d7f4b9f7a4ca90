// SPDX-License-Identifier: Apache-2.0
// How far the numbers of a compiled model may be from those of its text.
#pragma once

namespace hypgen::exact {

// How far a model may be from the real numbers of its text. The compiler knows it (`dsl/ir/rounding.py`).
struct TextRounding {
  double reward = 0.0;  // of what a step earns; infinite where the text does not limit it
  double start = 0.0;   // sum of the differences of all probabilities of what is drawn at the start ...
  double step = 0.0;    // ... and of what a step draws
  double lost = 0.0;    // the part of `step` that may be outcomes which are never drawn
  // No probability of a step differs by more than this part of itself, but for parts that add up to `rest`.
  double relative = 0.0;
  double rest = 0.0;
  // The most that a step can earn in terms that read what it draws, and that an episode can earn; infinite
  // where the text does not limit it.
  double drawn_reward = 0.0;
  double largest_return = 0.0;
};

}  // namespace hypgen::exact
