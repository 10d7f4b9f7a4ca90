// SPDX-License-Identifier: Apache-2.0
#include "hypgen/verify/belief_check.hpp"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/core/interrupt.hpp"
#include "hypgen/core/program.hpp"
#include "hypgen/episode/world.hpp"
#include "hypgen/math/float_bits.hpp"
#include "hypgen/random/philox.hpp"

namespace hypgen {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kWhetherSite = site_id("calibration:whether"),
                        kActionSite = site_id("calibration:action"), kStopSite = site_id("calibration:stop"),
                        kEntrySite = site_id("calibration:entry"), kTieSite = site_id("calibration:tie");

// Plays the episodes of one thread.
class BeliefChecker {
 public:
  BeliefChecker(const ModelDescriptor& model, const ModelInstance& instance,
                const BeliefCheckOptions& options)
      : model_(model),
        options_(options),
        steps_(model.horizon > 0 ? std::min(model.horizon, options.steps) : options.steps),
        world_(instance.make_world(options.seed)),
        seen_(instance.make_belief(options.seed, 1, BeliefKind::kVisible)),
        belief_(instance.make_belief(options.seed, options.particles, options.belief)),
        visible_(static_cast<std::size_t>(model.visible_count) + 1),
        truth_(static_cast<std::size_t>(model.variable_count) + 1) {}

  // The line of an episode; empty if an interrupt cut it short.
  //
  // An episode is stopped where it has been decided beforehand: at a step of another one's length. To choose
  // among its own steps would tell of its end, which the belief does not know. One that ends before is replaced.
  std::string episode(std::uint64_t number) {
    std::uint64_t run = number * kRuns;
    int stop = 0;
    for (int i = 0; i < kTries && !interrupted(); ++i, run += 2) {
      PhiloxDraws draws = draws_of(run, 0);
      stop = static_cast<int>(entry(draws.word(kStopSite, 0), static_cast<std::uint64_t>(length(run + 1))));
      if (stop < length(run)) break;
      stop = 0;  // where the start is too, in the last run that is tried
    }
    const int unexplained = play(*belief_, run, stop).unexplained;
    if (interrupted()) return "";
    const Json line = {{"type", "ranks"},
                       {"episode", number},
                       {"step", stop},
                       {"unexplained", unexplained},
                       {"ranks", ranks(run)}};
    return line.dump() + "\n";
  }

 private:
  static constexpr int kTries = 32;
  static constexpr std::uint64_t kRuns = 2 * (kTries + 1);
  static constexpr std::uint64_t kFirstStream = std::uint64_t{1} << 32;  // other tests take the ones before

  struct Played {
    int beliefs = 0;      // met, the first one included
    int unexplained = 0;  // steps, and a start, that nothing in the belief explains
  };

  PhiloxDraws draws_of(std::uint64_t run, int step) const {
    return {derive(options_.seed, StreamKind::kTest, kFirstStream + run), static_cast<std::uint32_t>(step),
            0};
  }

  static std::uint64_t entry(std::uint32_t word, std::uint64_t count) { return (word * count) >> 32; }

  // The number of beliefs of a run.
  int length(std::uint64_t run) { return play(*seen_, run, steps_ - 1).beliefs; }

  // Plays a run until `stop` steps are done or it ends.
  Played play(Belief& belief, std::uint64_t run, int stop) {
    world_->reset(run);
    world_->export_visible(visible_.data());
    Played played{1, belief.init(visible_.data(), run) == Status::kOk ? 0 : 1};
    for (int t = 0; t < stop && !interrupted(); ++t, ++played.beliefs) {
      const int action = choose(belief, run, t);
      if (action < 0) break;
      const WorldStep step = world_->step(action);
      if (step.result.terminal) break;
      if (belief.update(action, step.key) == Status::kOk) continue;
      belief.propagate(action, step.key);
      ++played.unexplained;
    }
    return played;
  }

  // One step of four any legal action, otherwise the default policy's; -1 if none is legal. It depends on
  // nothing hidden, so that all beliefs choose the same.
  int choose(const Belief& belief, std::uint64_t run, int t) {
    PhiloxDraws draws = draws_of(run, t);
    if (draws.word(kWhetherSite, 0) >> 30 != 0)
      return belief.default_action({draws.word(kActionSite, 1), draws.word(kActionSite, 2)});
    std::vector<int> legal;
    for (int action = 0; action < model_.action_count; ++action) {
      if (world_->is_legal(action)) legal.push_back(action);
    }
    return legal.empty() ? -1 : legal[entry(draws.word(kActionSite, 0), legal.size())];
  }

  // The rank of one entry of each hidden variable.
  std::vector<double> ranks(std::uint64_t run) {
    world_->export_state(truth_.data());
    PhiloxDraws draws = draws_of(run, 0);
    std::vector<double> result;
    for (const HiddenVariable& variable : model_.hidden_variables) {
      const auto i = static_cast<std::uint32_t>(result.size());
      const auto count = static_cast<std::uint64_t>(variable.count);
      const int index = variable.first + static_cast<int>(entry(draws.word(kEntrySite, i), count));
      const double tie = (draws.word(kTieSite, i) + 0.5) * 0x1p-32;
      result.push_back(rank(index, variable.is_float, tie));
    }
    return result;
  }

  double rank(int index, bool is_float, double tie) const {
    const auto number = [is_float](std::int32_t value) {
      return is_float ? static_cast<double>(math::from_bits(static_cast<std::uint32_t>(value))) : value;
    };
    const double truth = number(truth_[static_cast<std::size_t>(index)]);
    double below = 0.0, above = 0.0;
    belief_->each_value(index, [&](std::int32_t value, double weight) {
      const double other = number(value);
      below += other < truth ? weight : 0.0;
      above += other > truth ? weight : 0.0;
    });
    return std::clamp(below + tie * (1.0 - above - below), 0.0, 1.0);
  }

  const ModelDescriptor& model_;
  const BeliefCheckOptions& options_;
  int steps_;
  std::unique_ptr<World> world_;
  std::unique_ptr<Belief> seen_;  // acts as `belief_` does, and costs little
  std::unique_ptr<Belief> belief_;
  std::vector<std::int32_t> visible_, truth_;
};

std::string first_line(const ModelDescriptor& model, const BeliefCheckOptions& options) {
  Json names = Json::array();
  for (const HiddenVariable& variable : model.hidden_variables) names.push_back(variable.name);
  const Json line = {{"type", "beliefs"},    {"model", model.name},    {"hash", model.hash},
                     {"seed", options.seed}, {"steps", options.steps}, {"particles", options.particles},
                     {"variables", names}};
  return line.dump() + "\n";
}

}  // namespace

int check_beliefs(const ModelDescriptor& model, const ModelInstance& instance,
                  const BeliefCheckOptions& options) {
  Output out(options.json_file.empty() ? "-" : options.json_file, Output::Kind::kLines);
  std::mutex guard;
  const auto write = [&](const std::string& line) {
    const std::lock_guard<std::mutex> lock(guard);
    return out.write(line);
  };
  catch_interrupts();
  std::atomic<std::uint64_t> next{0};
  const auto work = [&](BeliefChecker& checker) {
    for (std::uint64_t number; (number = next++) < options.episodes && !interrupted();) {
      if (!write(checker.episode(number))) return;
    }
  };
  if (write(first_line(model, options))) {
    std::deque<BeliefChecker> checkers;  // made here, where a lack of memory is told
    while (checkers.size() < options.threads) checkers.emplace_back(model, instance, options);
    std::vector<std::thread> others;
    for (std::size_t i = 1; i < checkers.size(); ++i) others.emplace_back(work, std::ref(checkers[i]));
    work(checkers[0]);
    for (std::thread& other : others) other.join();
  }
  if (!out.close()) return complain(model.name, out);
  return interrupted() ? interrupt_code() : kDone;
}

}  // namespace hypgen
