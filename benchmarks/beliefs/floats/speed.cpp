// SPDX-License-Identifier: Apache-2.0
// Prints the processor time in which a policy's history takes in a step, by mean and deviation.
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <hypgen/model/descriptor.hpp>

#include "cart.hpp"
#include "sonar.hpp"

namespace {

constexpr int kSteps = 200000;
constexpr int kEpisode = 20;

template <class M>
void time_steps(const char* name, const typename M::Params& params, unsigned keys, int action) {
  const typename M::Fixed fixed{};
  const typename M::State state{};
  typename M::History history{};
  typename M::History after{};
  std::uint32_t random = 1;
  const std::clock_t start = std::clock();
  for (int i = 0; i < kSteps; ++i) {
    if (i % kEpisode == 0) M::init_history(params, fixed, state, history);
    random = random * 1664525U + 1013904223U;
    M::advance_history(params, fixed, state, action, (random >> 16) % keys, state, history, after);
    history = after;
  }
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  std::printf("%s: %.2f us a step\n", name, seconds / kSteps * 1e6);
}

}  // namespace

int main() {
  using hypgen::models::Cart;
  using hypgen::models::Sonar;
  time_steps<Cart>("cart", Cart::Params{}, 16, 1);
  Sonar::Params params{};
  params.noise = 2.0F;
  time_steps<Sonar>("sonar", params, 32, 0);
}
