// SPDX-License-Identifier: Apache-2.0
// A robot's loop in C++: prints what to do, and reads "good", "bad" or "nothing" as what the robot then saw.
#include <array>
#include <cstdint>
#include <exception>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>

#include "rock_sample.h"

namespace {

// A planner that throws what a refused call says.
class Planner {
 public:
  explicit Planner(const char* settings) {
    const hypgen_options options = {sizeof options, settings, nullptr};
    hypgen_planner* planner = nullptr;
    call(hypgen_create, hypgen_model_rock_sample(), &options, &planner);
    planner_.reset(planner);
  }

  void reset() { call(hypgen_reset, planner_.get(), nullptr, 0, 0); }

  hypgen_decision plan(double seconds) {
    hypgen_decision decision = {};
    decision.size = sizeof decision;
    call(hypgen_plan, planner_.get(), seconds, &decision);
    return decision;
  }

  void update(std::int32_t action, std::int32_t reading) {
    std::array<std::int32_t, ROCK_SAMPLE_SEEN> seen{};
    seen[ROCK_SAMPLE_SEES_READING] = reading;
    call(hypgen_update_values, planner_.get(), action, seen.data(), seen.size());
  }

  double probability(const char* variable, const char* value) {
    double found = 0.0;
    call(hypgen_probability, planner_.get(), variable, value, &found);
    return found;
  }

 private:
  struct Destroy {
    void operator()(hypgen_planner* planner) const { hypgen_destroy(planner); }
  };

  template <class Function, class... Arguments>
  static void call(Function function, Arguments... arguments) {
    char* error = nullptr;
    const hypgen_status status = function(arguments..., &error);
    const std::unique_ptr<char, void (*)(char*)> text(error, hypgen_free);
    if (status >= HYPGEN_FAILED) throw std::runtime_error(text ? text.get() : hypgen_status_name(status));
  }

  std::unique_ptr<hypgen_planner, Destroy> planner_;
};

std::int32_t code_of(const std::string& reading) {
  if (reading == "good") return ROCK_SAMPLE_READING_LOOKS_GOOD;
  if (reading == "bad") return ROCK_SAMPLE_READING_LOOKS_BAD;
  return ROCK_SAMPLE_READING_NOTHING;
}

}  // namespace

int main() {
  try {
    Planner planner("mode=despot trials=300 scenarios=200 seed=7");
    planner.reset();
    for (int step = 0; step < 20; ++step) {
      const hypgen_decision decision = planner.plan(0.1);
      const bool checks = rock_sample_act_is_check(decision.action) != 0;
      std::cout << decision.action_name << (checks ? ": looks at rock " : "");
      if (checks) std::cout << rock_sample_act_check_argument(decision.action);
      std::cout << std::endl;
      std::string reading;
      if (!std::getline(std::cin, reading)) break;
      planner.update(decision.action, code_of(reading));
    }
    std::cout << "rock 0 is good with probability " << planner.probability("rock.good[0]", "true") << '\n';
    return 0;
  } catch (const std::exception& problem) {
    std::cerr << problem.what() << '\n';
    return 1;
  }
}
