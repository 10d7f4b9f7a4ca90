// SPDX-License-Identifier: Apache-2.0
// A robot's loop in C++: prints what to do, and reads "good", "bad" or "nothing" as what the robot then saw.
#include <cstdint>
#include <exception>
#include <hypgen.hpp>
#include <iostream>
#include <string>

#include "rock_sample.h"

namespace {

std::int32_t code_of(const std::string& reading) {
  if (reading == "good") return ROCK_SAMPLE_READING_LOOKS_GOOD;
  if (reading == "bad") return ROCK_SAMPLE_READING_LOOKS_BAD;
  return ROCK_SAMPLE_READING_NOTHING;
}

}  // namespace

int main() {
  try {
    hypgen::api::Planner planner(hypgen_model_rock_sample(), "mode=despot trials=300 scenarios=200 seed=7");
    planner.reset();
    for (int step = 0; step < 20; ++step) {
      const hypgen_decision decision = planner.plan(0.1);
      const bool checks = rock_sample_act_is_check(decision.action) != 0;
      std::cout << decision.action_name << (checks ? ": looks at rock " : "");
      if (checks) std::cout << rock_sample_act_check_argument(decision.action);
      std::cout << std::endl;
      std::string reading;
      if (!std::getline(std::cin, reading)) break;
      planner.update_values(decision.action, {code_of(reading)});
    }
    std::cout << "rock 0 is good with probability " << planner.probability("rock.good[0]", "true") << '\n';
    return 0;
  } catch (const std::exception& problem) {
    std::cerr << problem.what() << '\n';
    return 1;
  }
}
