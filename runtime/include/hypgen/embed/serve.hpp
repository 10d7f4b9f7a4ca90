// SPDX-License-Identifier: Apache-2.0
// An agent for programs in any language: requests and answers are lines of JSON.
#pragma once

#include <functional>
#include <string>

#include "hypgen/embed/agent.hpp"

namespace hypgen {

// The answer to one request: a JSON object with its status, and `error` if it was refused. A request that is no
// JSON, or asks for what is not known, is refused with kWrongArgument. `ends` tells whether it was the last one.
std::string answer(Agent& agent, const std::string& request, bool& ends);

// Answers the lines that `read` gives, until it has none, `write` fails or a request ends it. False if a write
// has failed.
bool serve(Agent& agent, const std::function<bool(std::string&)>& read,
           const std::function<bool(const std::string&)>& write);

}  // namespace hypgen
