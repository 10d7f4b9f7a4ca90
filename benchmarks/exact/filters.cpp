// SPDX-License-Identifier: Apache-2.0
// How far a solver's belief is from the exact one, on episodes of random legal actions.
//
//   filters KIND PARTICLES EPISODES STEPS SEED        KIND: exact, limit, particle or factored
//
// With STEPS 0 it looks at the belief at the start, which counts as one step. It
// prints a line of JSON: the mean and the largest total variation over all steps, the largest difference in
// the probability of a single variable's value, how many steps that were, after how many an observation had
// no explanation, and how often the true state after the last of STEPS steps had each rank among nine samples
// of the belief (0 to 9; a calibrated belief gives all equally often).
//
// `limit` is the particle filter with infinitely many particles: all outcomes of the model's `init_hidden` and
// `filter`, weighed as it says.
//
// filter_program.py puts this in the place of `main` in a generated exact.cpp, whose `Model` and `descriptor`
// it uses.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <hypgen/belief/factored_belief.hpp>
#include <hypgen/belief/particle_belief.hpp>
#include <hypgen/exact/enumeration.hpp>
#include <hypgen/exact/filter.hpp>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

namespace {

using hypgen::exact::ExactModel;
using hypgen::exact::SparseBelief;

constexpr int kSamples = 9;
constexpr std::uint32_t kActionSite = 1, kRankSite = 2, kTieSite = 3;

// One that plays and is looked at: what happened, and the exact belief after it.
struct Step {
  int action;  // -1: nothing has happened yet
  Model::Key key;
  SparseBelief exact;
};

struct Episode {
  std::vector<std::int32_t> visible;  // at the start
  std::vector<Step> steps;
  int state = 0;  // the true one after the last step
};

// Finds states of the enumerated model by their values.
class StateIndex {
 public:
  explicit StateIndex(const ExactModel& model) {
    const auto width = static_cast<std::size_t>(model.variables);
    for (int state = 0; state < model.states; ++state) {
      number_[bytes(model.values.data() + static_cast<std::size_t>(state) * width)] = state;
    }
  }

  int find(const Model::Fixed& fixed, const Model::State& state) const {
    std::int32_t values[Model::kVariableCount];
    Model::export_state(fixed, state, values);
    return number_.at(bytes(values));
  }

 private:
  static std::string bytes(const std::int32_t* values) {
    return {reinterpret_cast<const char*>(values), Model::kVariableCount * sizeof *values};
  }

  std::unordered_map<std::string, int> number_;
};

// What infinitely many particles would hold: each state with its weight.
class LimitBelief {
 public:
  LimitBelief(const Model::Params& params, const StateIndex& index) : params_(params), index_(index) {}

  void init(const std::vector<std::int32_t>& visible) {
    states_.clear();
    hypgen::exact::EnumeratingDraws draws;
    do {
      Model::Fixed fixed;
      Model::State state;
      Model::import_visible(visible.data(), fixed, state);
      Model::init_hidden(params_, draws, fixed, state);
      double weight = draws.probability();
      if constexpr (hypgen::SeesFirst<Model>::value) weight *= likelihood<Model>(fixed, state);
      if (weight > 0.0) add(fixed, state, weight, states_);
    } while (draws.next());
    normalise();
  }

  void update(int action, const Model::Key& key) {
    std::map<int, Weighted> next_states;
    for (const auto& [number, from] : states_) {
      hypgen::exact::EnumeratingDraws draws;
      do {
        Model::State next;
        const double density = Model::filter(params_, from.fixed, from.state, action, key, draws, next);
        const double weight = from.weight * draws.probability() * density;
        if (weight > 0.0) add(from.fixed, next, weight, next_states);
      } while (draws.next());
    }
    states_ = std::move(next_states);
    normalise();
  }

  SparseBelief belief(int states) const {
    SparseBelief result(states);
    for (const auto& [number, state] : states_) result.insertBack(number) = state.weight;
    return result;
  }

 private:
  struct Weighted {
    Model::Fixed fixed;
    Model::State state;
    double weight;
  };

  template <class M>  // as not every model has an init_likelihood
  double likelihood(const typename M::Fixed& fixed, const typename M::State& state) const {
    return M::init_likelihood(params_, fixed, state);
  }

  void add(const Model::Fixed& fixed, const Model::State& state, double weight,
           std::map<int, Weighted>& to) const {
    to.try_emplace(index_.find(fixed, state), Weighted{fixed, state, 0.0}).first->second.weight += weight;
  }

  void normalise() {
    double total = 0.0;
    for (const auto& [number, state] : states_) total += state.weight;
    for (auto& [number, state] : states_) state.weight /= total;
  }

  const Model::Params& params_;
  const StateIndex& index_;
  std::map<int, Weighted> states_;
};

double unit(hypgen::StreamKey key, std::uint32_t number, std::uint32_t site, std::uint32_t index) {
  hypgen::PhiloxDraws draws(key, number, 0);
  return (draws.word(site, index) + 0.5) / 4294967296.0;
}

class Comparison {
 public:
  Comparison(const Model::Params& params, const ExactModel& model, std::uint64_t seed)
      : params_(params),
        model_(model),
        index_(model),
        world_(hypgen::derive(seed, hypgen::StreamKind::kWorld, 0)),
        choices_(hypgen::derive(seed, hypgen::StreamKind::kTest, 0)) {}

  Episode play(std::uint32_t run, int steps) const {
    Episode episode;
    Model::Fixed fixed;
    Model::State state;
    hypgen::PhiloxDraws first(world_, run, 0);
    Model::init_visible(params_, first, fixed, state);
    Model::init_hidden(params_, first, fixed, state);
    episode.visible.resize(Model::kVisibleCount + 1);
    Model::export_visible(fixed, state, episode.visible.data());
    hypgen::exact::ExactFilter exact(model_);
    if (!exact.init(episode.visible.data())) std::abort();
    if (steps == 0) episode.steps.push_back({-1, {}, exact.belief()});
    for (int t = 0; t < steps; ++t) {
      const int action = choose(fixed, state, run, t);
      hypgen::PhiloxDraws draws(world_, run, static_cast<std::uint32_t>(t) + 1);
      Model::State next;
      if (action < 0 || Model::step(params_, fixed, state, action, draws, next).terminal) break;
      const Model::Key key = Model::observe(params_, fixed, state, action, draws, next);
      if (!exact.update(action, hypgen::words_of(key))) std::abort();  // what happens can happen
      episode.steps.push_back({action, key, exact.belief()});
      state = next;
    }
    episode.state = index_.find(fixed, state);
    return episode;
  }

  const StateIndex& index() const { return index_; }

  // The weights of a belief's particles, added up by state.
  SparseBelief of_particles(const hypgen::Belief& belief, hypgen::ScenarioBuffer& buffer) const {
    std::vector<double> weights;
    belief.export_particles(buffer, weights);
    std::vector<Model::Fixed> fixed(weights.size());
    std::vector<Model::State> states(weights.size());
    buffer.copy_to(fixed.data(), states.data());
    std::map<int, double> sums;
    for (std::size_t i = 0; i < weights.size(); ++i) {  // without weight, the state may be one past the end
      if (weights[i] > 0.0) sums[index_.find(fixed[i], states[i])] += weights[i];
    }
    SparseBelief result(model_.states);
    for (const auto& [state, weight] : sums) result.insertBack(state) = weight;
    return result;
  }

  // The product of the probabilities of all variables' values, for the states of a class.
  SparseBelief of_marginals(const hypgen::Belief& belief, int of_class) const {
    SparseBelief result(model_.states);
    std::map<std::pair<int, std::int32_t>, double> known;
    for (int state = model_.class_begin[of_class]; state < model_.class_begin[of_class + 1]; ++state) {
      double product = 1.0;
      for (int variable = 0; variable < model_.variables; ++variable) {
        const std::int32_t value = model_.values[state * model_.variables + variable];
        const auto [found, is_new] = known.try_emplace({variable, value}, 0.0);
        if (is_new) found->second = belief.marginal(variable, value);
        product *= found->second;
      }
      result.insertBack(state) = product;
    }
    return result;
  }

  // The largest difference of two beliefs in the probability of a variable's value.
  double marginal_distance(const SparseBelief& a, const SparseBelief& b) const {
    const SparseBelief difference = a - b;
    std::map<std::pair<int, std::int32_t>, double> sums;
    for (SparseBelief::InnerIterator state(difference); state; ++state) {
      for (int variable = 0; variable < model_.variables; ++variable) {
        const auto row = static_cast<int>(state.index()) * model_.variables;
        sums[{variable, model_.values[row + variable]}] += state.value();
      }
    }
    double largest = 0.0;
    for (const auto& [value, sum] : sums) largest = std::max(largest, std::abs(sum));
    return largest;
  }

  // The rank of the true state among samples of a belief; equal ones are ordered at random.
  int rank(const SparseBelief& belief, int truth, std::uint32_t run) const {
    int less = 0, equal = 0;
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      double left = unit(choices_, run, kRankSite, i);
      int sampled = 0;
      for (SparseBelief::InnerIterator state(belief); state; ++state) {
        sampled = static_cast<int>(state.index());
        left -= state.value();
        if (left < 0.0) break;
      }
      less += sampled < truth ? 1 : 0;
      equal += sampled == truth ? 1 : 0;
    }
    return less + static_cast<int>(unit(choices_, run, kTieSite, 0) * (equal + 1));
  }

 private:
  int choose(const Model::Fixed& fixed, const Model::State& state, std::uint32_t run, int t) const {
    std::vector<int> legal;
    for (int action = 0; action < Model::kActionCount; ++action) {
      if (Model::is_legal(params_, fixed, state, action)) legal.push_back(action);
    }
    if (legal.empty()) return -1;
    const double share = unit(choices_, run, kActionSite, static_cast<std::uint32_t>(t));
    return legal[static_cast<std::size_t>(share * static_cast<double>(legal.size()))];
  }

  const Model::Params& params_;
  const ExactModel& model_;
  StateIndex index_;
  hypgen::StreamKey world_;
  hypgen::StreamKey choices_;
};

// Whether a factored belief has particles; if not, its marginals say all.
template <class M>
constexpr bool has_particle_units() {
  if constexpr (M::kFactored) return M::kParticleUnits > 0;
  return false;
}

template <class M>  // as not every model has a factored belief
std::unique_ptr<hypgen::Belief> make_belief(const std::string& kind, const typename M::Params& params,
                                            std::uint64_t seed, std::size_t particles) {
  if constexpr (M::kFactored) {
    if (kind == "factored") return std::make_unique<hypgen::FactoredBelief<M>>(params, seed, particles);
  }
  if (kind == "particle") return std::make_unique<hypgen::ParticleBelief<M>>(params, seed, particles);
  return nullptr;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 6) return 2;
  const std::string kind = argv[1];
  const std::size_t particles = std::strtoul(argv[2], nullptr, 10);
  const auto episodes = static_cast<std::uint32_t>(std::atoi(argv[3]));
  const int steps = std::atoi(argv[4]);
  const std::uint64_t seed = std::strtoull(argv[5], nullptr, 10);

  const hypgen::ModelDescriptor described = descriptor();
  Model::Params params;
  std::string error;
  if (!Model::load(hypgen::ParamValues(described.params), params, error)) return 2;
  const hypgen::exact::Enumeration enumeration =
      hypgen::exact::enumerate(hypgen::exact::TypedOutcomeModel<Model>(params), described.discount, 0, {},
                               [](const hypgen::exact::EnumerationCounts&) { return true; });
  if (!enumeration.problem.empty()) return 2;
  const Comparison comparison(params, enumeration.model, seed);
  const auto belief = make_belief<Model>(kind, params, seed, particles);
  LimitBelief limit(params, comparison.index());
  hypgen::ScenarioBuffer buffer;
  if (belief) belief->reserve(buffer, particles);

  double sum = 0.0, largest = 0.0, marginal = 0.0;
  int updates = 0, failures = 0;
  int ranks[kSamples + 1] = {};
  for (std::uint32_t run = 0; run < episodes; ++run) {
    const Episode episode = comparison.play(run, steps);
    if (belief) belief->init(episode.visible.data(), run);
    if (kind == "limit") limit.init(episode.visible);
    SparseBelief held;
    for (const Step& step : episode.steps) {
      const bool is_later = step.action >= 0;
      if (is_later && belief &&
          belief->update(step.action, hypgen::words_of(step.key)) != hypgen::Status::kOk) {
        ++failures;
        held = {};
        break;
      }
      const int any = static_cast<int>(SparseBelief::InnerIterator(step.exact).index());
      if (kind == "limit") {
        if (is_later) limit.update(step.action, step.key);
        held = limit.belief(enumeration.model.states);
      } else if (kind == "particle" || (kind == "factored" && has_particle_units<Model>())) {
        held = comparison.of_particles(*belief, buffer);
      } else if (kind == "factored") {
        held = comparison.of_marginals(*belief, enumeration.model.seen[any]);
      } else {
        held = step.exact;
      }
      const double distance = hypgen::exact::total_variation(held, step.exact);
      sum += distance;
      largest = std::max(largest, distance);
      marginal = std::max(marginal, comparison.marginal_distance(held, step.exact));
      ++updates;
    }
    // An episode that ended early tells more of its last state than the belief before could know.
    const bool is_whole = episode.steps.size() >= static_cast<std::size_t>(steps);
    if (is_whole && held.nonZeros() > 0) ++ranks[comparison.rank(held, episode.state, run)];
  }
  std::printf(
      "{\"kind\": \"%s\", \"particles\": %zu, \"updates\": %d, \"failures\": %d, \"mean\": %.9g, "
      "\"largest\": %.9g, \"marginal\": %.9g, \"ranks\": [",
      kind.c_str(), particles, updates, failures, updates > 0 ? sum / updates : 0.0, largest, marginal);
  for (int i = 0; i <= kSamples; ++i) std::printf("%s%d", i > 0 ? ", " : "", ranks[i]);
  std::printf("]}\n");
  return 0;
}
