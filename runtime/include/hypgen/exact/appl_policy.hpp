// SPDX-License-Identifier: Apache-2.0
// Policies in the format of APPL, the library of SARSOP (Kurniawati, Hsu and Lee, RSS 2008).
//
// It is XML: `AlphaVector` has a `Vector` for each alpha vector, with the number of its action and a value for
// each state. Its states are those of the model that `hypgen export` writes, in that file's order, and nothing
// is fully observed. In a file of ours, a comment has the names of actions and states, and the hash of the
// model. A vector of one class of states is there worth `outside`, less than any value, in states that look
// different.
#pragma once

#include <cstddef>
#include <iosfwd>
#include <string>

#include "hypgen/exact/exact_instance.hpp"
#include "hypgen/exact/exact_model.hpp"
#include "hypgen/exact/policy.hpp"

namespace hypgen::exact {

// No file has more numbers than this.
constexpr std::size_t kMostPolicyNumbers = 50000000;

// Why a policy is too large for the format; empty if it is not.
std::string appl_policy_problem(const ExactModel& model, const AlphaPolicy& policy);

void write_appl_policy(std::ostream& out, const ExactDescriptor& descriptor, const ExactModel& model,
                       const AlphaPolicy& policy);

// Reads what this or another program has written. Without our comment a file of another model is known by its
// sizes alone. Throws PolicyError.
AlphaPolicy read_appl_policy(std::istream& in, const ExactDescriptor& descriptor, const ExactModel& model);

// Whether a file that begins so may be in this format.
inline bool is_appl_policy(int first_character) { return first_character == '<'; }

}  // namespace hypgen::exact
