// SPDX-License-Identifier: Apache-2.0
// Compares the upper bound in every state that can be reached with the value of knowing the state, and the
// lower one with what the default policy earns, both computed here from the whole model's step. Prints how
// many states there are, the least and the largest of bound minus value, the largest value, and the least and
// the largest of the policy's value minus its bound (of a policy without a history). MODEL is the model's
// type, HEADER its generated header.
#include <cstdio>
#include <cstring>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "hypgen/random/enumerating_draws.hpp"

#include HEADER

using M = hypgen::models::MODEL;

struct Place {
  M::Fixed fixed;
  M::State state;
};

struct Less {
  bool operator()(const Place& a, const Place& b) const { return std::memcmp(&a, &b, sizeof a) < 0; }
};

struct Outcome {
  std::size_t next;
  double probability;
};

struct Choice {
  int action = 0;
  double chosen = 0.0;  // with what probability the default policy does
  double reward = 0.0;
  std::vector<Outcome> outcomes;
};

int main(int, char** argv) {
  const double discount = std::atof(argv[1]);
  M::Params params{};
  std::string error;
  if (!M::load(hypgen::ParamValues{}, params, error)) return 1;
  std::map<Place, std::size_t, Less> numbers;
  std::vector<Place> places;
  const auto number = [&](const Place& place) {
    const auto [found, fresh] = numbers.emplace(place, places.size());
    if (fresh) places.push_back(place);
    return found->second;
  };
  hypgen::exact::EnumeratingDraws draws;
  do {
    Place place;
    M::init_visible(params, draws, place.fixed, place.state);
    M::init_hidden(params, draws, place.fixed, place.state);
    number(place);
  } while (draws.next());
  std::vector<std::vector<Choice>> choices;
  for (std::size_t i = 0; i < places.size(); ++i) {
    choices.emplace_back();
    const Place place = places[i];
    for (int action = 0; action < M::kActionCount; ++action) {
      if (!M::is_legal(params, place.fixed, place.state, action)) continue;
      Choice choice;
      choice.action = action;
      draws.start();
      do {
        Place next{place.fixed, {}};
        const hypgen::StepResult result =
            M::step(params, place.fixed, place.state, action, draws, next.state);
        choice.reward += draws.probability() * hypgen::from_fixed_sum(result.reward);
        if (!result.terminal) choice.outcomes.push_back({number(next), draws.probability()});
      } while (draws.next());
      choices[i].push_back(choice);
    }
    draws.start();
    do {
      const int chosen = M::default_policy(params, place.fixed, place.state, M::History{}, draws);
      for (Choice& choice : choices[i]) {
        if (choice.action == chosen) choice.chosen += draws.probability();
      }
    } while (draws.next());
  }
  std::vector<double> values(places.size(), 0.0), earned(places.size(), 0.0);
  for (int sweep = 0; sweep < 2000; ++sweep) {
    const std::vector<double> earned_before = earned;
    for (std::size_t i = 0; i < places.size(); ++i) {
      double best = choices[i].empty() ? 0.0 : -1e30;
      earned[i] = 0.0;
      for (const Choice& choice : choices[i]) {
        double value = choice.reward, own = choice.reward;
        for (const Outcome& o : choice.outcomes) {
          value += discount * o.probability * values[o.next];
          own += discount * o.probability * earned_before[o.next];
        }
        best = value > best ? value : best;
        earned[i] += choice.chosen * own;
      }
      values[i] = best;
    }
  }
  double least = 1e30, most = -1e30, largest = -1e30, under = 1e30, deepest = -1e30;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double over = static_cast<double>(M::upper(params, places[i].fixed, places[i].state)) - values[i];
    least = over < least ? over : least;
    most = over > most ? over : most;
    largest = values[i] > largest ? values[i] : largest;
    const float lower = M::lower(params, places[i].fixed, places[i].state, M::History{});
    const double below = earned[i] - static_cast<double>(lower);
    under = below < under ? below : under;
    deepest = below > deepest ? below : deepest;
  }
  std::printf("%zu %.9g %.9g %.9g %.9g %.9g\n", places.size(), least, most, largest, under, deepest);
  return 0;
}
