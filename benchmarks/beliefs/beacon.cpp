// SPDX-License-Identifier: Apache-2.0
// The body of a program that standing.py makes of a model's file: argv[1] episodes, argv[2] particles, argv[3]
// steps, argv[4] seed. In each episode the beacon stands near the edge of the lane. It prints a line of figures.

// Bayes' rule for the beacon's y and the gauge, on a grid. The swell of a step adds to the sensor's noise.
class Grid {
 public:
  Grid() {
    for (int k = 0; k < kPoints; ++k) free_[k] = stuck_[k] = 0.5;
  }

  void see(int bin) {
    for (int k = 0; k < kPoints; ++k) {
      const double free = 0.9 * free_[k] + 0.1 * stuck_[k], stuck = 0.1 * free_[k] + 0.9 * stuck_[k];
      free_[k] = free * chance(bin, y(k));
      stuck_[k] = stuck * chance(bin, y(k) + 0.6);
    }
  }

  // The mean and the deviation of y.
  void moments(double& mean, double& deviation) const {
    double total = 0.0, sum = 0.0, squares = 0.0;
    for (int k = 0; k < kPoints; ++k) {
      const double p = free_[k] + stuck_[k];
      total += p;
      sum += p * y(k);
      squares += p * y(k) * y(k);
    }
    mean = sum / total;
    deviation = std::sqrt(squares / total - mean * mean);
  }

 private:
  static constexpr int kPoints = 1600;
  static double y(int k) { return -0.5 + 16.0 * (k + 0.5) / kPoints; }
  static double below(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }
  static double chance(int bin, double mean) {
    const double noise = 0.25 * std::sqrt(2.0), low = -8.0 + 0.5 * bin;
    return below((low + 0.5 - mean) / noise) - below((low - mean) / noise);
  }

  double free_[kPoints], stuck_[kPoints];
};

int main(int, char** argv) {
  using namespace hypgen;
  using M = models::Beacon;
  constexpr std::size_t kSamples = 20000;
  const int episodes = std::atoi(argv[1]), steps = std::atoi(argv[3]);
  const std::uint64_t seed = std::strtoull(argv[4], nullptr, 10);
  M::Params params{};
  std::string error;
  if (!M::load(ParamValues{}, params, error)) return 1;
  ParticleBelief<M> belief(params, seed, std::strtoul(argv[2], nullptr, 10));
  ScenarioBuffer buffer;
  belief.reserve(buffer, kSamples);
  std::vector<M::Fixed> samples(kSamples);
  std::vector<M::State> states(kSamples);
  double squared_distance = 0.0, width = 0.0, exact_width = 0.0, seconds = 0.0;
  int beyond_two = 0, beyond_three = 0, sure_wrongly = 0, unexplained = 0;
  for (int episode = 0; episode < episodes; ++episode) {
    const auto scenario = static_cast<std::uint32_t>(episode);
    const StreamKey key = derive(seed, StreamKind::kTest, 0);
    PhiloxDraws first(key, scenario, 0);
    M::Fixed fixed;
    M::State state;
    M::init_visible(params, first, fixed, state);
    M::init_hidden(params, first, fixed, state);
    const double truth = 8.2 + 0.4 * (first.word(1, 0) * 0x1p-32);
    fixed.set_beacon_y(static_cast<float>(truth));
    belief.init(nullptr, scenario);
    Grid grid;
    for (int t = 0; t < steps; ++t) {
      PhiloxDraws draws(key, scenario, static_cast<std::uint32_t>(t) + 1);
      M::State next;
      M::step(params, fixed, state, 0, draws, next);
      const M::Key seen = M::observe(params, fixed, state, 0, draws, next);
      state = next;
      grid.see(static_cast<int>(seen % 64));  // the last observation is the lowest digit
      const std::clock_t start = std::clock();
      if (belief.update(0, words_of(seen)) != Status::kOk) {
        ++unexplained;
        belief.propagate(0, words_of(seen));
      }
      seconds += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    }
    belief.sample(derive(seed, StreamKind::kPlan, scenario), 0, kSamples, buffer);
    buffer.copy_to(samples.data(), states.data());
    double sum = 0.0, squares = 0.0, in_lane = 0.0;
    for (const M::Fixed& sample : samples) {
      const double place = sample.beacon_y();
      sum += place;
      squares += place * place;
      in_lane += std::abs(place - 7.5) <= 0.9;
    }
    double exact_mean, exact_deviation;
    grid.moments(exact_mean, exact_deviation);
    const double mean = sum / kSamples, off = std::abs(mean - truth);
    const double deviation = std::sqrt(std::max(0.0, squares / kSamples - mean * mean));
    squared_distance += std::pow((mean - exact_mean) / exact_deviation, 2.0);
    width += deviation;
    exact_width += exact_deviation;
    beyond_two += off > 2 * deviation;
    beyond_three += off > 3 * deviation;
    sure_wrongly += truth <= 8.4 && in_lane / kSamples < 0.01;
  }
  const auto share = [&](int count) { return 100.0 * count / episodes; };
  std::printf("| %.2f | %.4f | %.4f | %.1f %% | %.1f %% | %.1f %% | %d | %.2f |\n",
              std::sqrt(squared_distance / episodes), width / episodes, exact_width / episodes,
              share(beyond_two), share(beyond_three), share(sure_wrongly), unexplained,
              1e3 * seconds / episodes / steps);
  return 0;
}
