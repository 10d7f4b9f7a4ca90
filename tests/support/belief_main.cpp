// SPDX-License-Identifier: Apache-2.0
// Plays a model and prints, after every step, how it ended, the action, the first word of what was seen and
// the probability of each value of each variable under a belief: argv[1] particles, argv[2] steps. MODEL is
// the model's type, HEADER its generated header, BELIEF the belief's template.
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "hypgen/belief/factored_belief.hpp"
#include "hypgen/belief/particle_belief.hpp"
#include "hypgen/episode/world.hpp"

#include HEADER

int main(int, char** argv) {
  using M = hypgen::models::MODEL;
  static M::Params params{};  // tables may not fit on the stack
  std::string error;
  if (!M::load(hypgen::ParamValues{}, params, error)) return 1;
  hypgen::BELIEF<M> belief(params, 0, std::strtoul(argv[1], nullptr, 10));
  hypgen::ModelWorld<M> world(params, 5);
  std::vector<std::int32_t> visible(M::kVisibleCount + 1);
  bool playing = false;
  std::uint64_t run = 0;
  for (int t = 0; t < std::atoi(argv[2]); ++t) {
    if (!playing) {
      world.reset(run);
      world.export_visible(visible.data());
      belief.init(visible.data(), run++);
      playing = true;
    }
    const int action = (t * 7 + t / 3) % M::kActionCount;
    const hypgen::WorldStep step = world.step(action);
    const hypgen::Status status =
        step.result.terminal ? hypgen::Status::kTerminal : belief.update(action, step.key);
    playing = status == hypgen::Status::kOk;
    const std::uint64_t key = step.result.terminal ? 0 : step.key[0];
    std::printf("%d %d %llu", static_cast<int>(status), action, static_cast<unsigned long long>(key));
    for (int variable = 0; variable < M::kVariableCount; ++variable) {
      for (std::int32_t value = 0; value < 8; ++value) {
        std::printf(" %.9g", playing ? belief.marginal(variable, value) : 0.0);
      }
    }
    std::printf("\n");
  }
  return 0;
}
