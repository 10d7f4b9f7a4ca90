// SPDX-License-Identifier: Apache-2.0
// An enumerated model as JSON lines, for programs that read it.
//
//   {"type":"model", "name", "hash", "policy_hash" (`model_hash`, which files of policies begin with),
//    "discount", "horizon" (0: none), "variables": [name, ..], "actions": [name, ..],
//    "observations": [name, ..], "states": N}
//   {"type":"start", "probability", "class", "belief": [[state, probability], ..]}           for each class
//   {"type":"state", "state", "class", "step" (where there is a horizon), "values": [text, ..]}   in order
//   {"type":"row", "state", "action", "reward", "outcomes": [[observation, next state, probability], ..]}
//       for each action that is legal in the state, state after state; outcomes are sorted, and what their
//       probabilities lack of 1 ends the episode
//   {"type":"end"}
//
// States, actions and observations are numbered from 0. States of one class agree in all that is visible.
#pragma once

#include "hypgen/core/output.hpp"
#include "hypgen/exact/exact_instance.hpp"
#include "hypgen/exact/exact_model.hpp"

namespace hypgen::exact {

// Writes all and closes `out`; false if that fails.
bool dump(const ExactDescriptor& descriptor, const ExactModel& model, Output& out);

}  // namespace hypgen::exact
