// SPDX-License-Identifier: Apache-2.0
// The body of a program that standing.py makes of a model's file: argv[1] episodes, argv[2] particles, argv[3]
// steps, argv[4] seed. In each episode person 0 stands near the edge of the lane. It prints a line of figures.
int main(int, char** argv) {
  using namespace hypgen;
  using M = models::StandingPeople;
  constexpr std::size_t kSamples = 20000;
  const int episodes = std::atoi(argv[1]), steps = std::atoi(argv[3]);
  const std::uint64_t seed = std::strtoull(argv[4], nullptr, 10);
  M::Params params{};
  std::string error;
  if (!M::load(ParamValues{}, params, error)) return 1;
  FactoredBelief<M> belief(params, seed, std::strtoul(argv[2], nullptr, 10));
  ScenarioBuffer buffer;
  belief.reserve(buffer, kSamples);
  std::vector<M::Fixed> fixed_samples(kSamples);
  std::vector<M::State> samples(kSamples);
  double error_sum = 0.0, deviation_sum = 0.0, seconds = 0.0;
  int beyond_two = 0, beyond_three = 0, sure_wrongly = 0, unexplained = 0;
  for (int episode = 0; episode < episodes; ++episode) {
    const auto scenario = static_cast<std::uint32_t>(episode);
    const StreamKey key = derive(seed, StreamKind::kTest, 0);
    PhiloxDraws first(key, scenario, 0);
    M::Fixed fixed;
    M::State state;
    M::init_visible(params, first, fixed, state);
    M::init_hidden(params, first, fixed, state);
    const auto uniform = [&](std::uint32_t i) { return first.word(1, i) * 0x1p-32; };
    const double x = 5.0 + 10.0 * uniform(0), y = 8.2 + 0.4 * uniform(1);
    state.set_person_x(0, static_cast<float>(x));
    state.set_person_y(0, static_cast<float>(y));
    fixed.set_person_stands(0, true);
    belief.init(nullptr, scenario);
    for (int t = 0; t < steps; ++t) {
      PhiloxDraws draws(key, scenario, static_cast<std::uint32_t>(t) + 1);
      M::State next;
      M::step(params, fixed, state, 0, draws, next);
      const M::Key seen = M::observe(params, fixed, state, 0, draws, next);
      state = next;
      const std::clock_t start = std::clock();
      if (belief.update(0, words_of(seen)) != Status::kOk) {
        ++unexplained;
        belief.propagate(0, words_of(seen));
      }
      seconds += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    }
    belief.sample(derive(seed, StreamKind::kPlan, scenario), 0, kSamples, buffer);
    buffer.copy_to(fixed_samples.data(), samples.data());
    double sum = 0.0, squares = 0.0, in_lane = 0.0;
    for (const M::State& sample : samples) {
      const double place = sample.person_y(0);
      sum += place;
      squares += place * place;
      in_lane += std::abs(place - 7.5) <= 0.9;
    }
    const double mean = sum / kSamples, off = std::abs(mean - y);
    const double deviation = std::sqrt(std::max(0.0, squares / kSamples - mean * mean));
    error_sum += off;
    deviation_sum += deviation;
    beyond_two += off > 2 * deviation;
    beyond_three += off > 3 * deviation;
    sure_wrongly += y <= 8.4 && in_lane / kSamples < 0.01;
  }
  const auto share = [&](int count) { return 100.0 * count / episodes; };
  std::printf("| %.4f | %.4f | %.1f %% | %.1f %% | %.1f %% | %d | %.2f |\n", error_sum / episodes,
              deviation_sum / episodes, share(beyond_two), share(beyond_three), share(sure_wrongly),
              unexplained, 1e3 * seconds / episodes / steps);
  return 0;
}
