// Compares the upper bound in every state that can be reached with the value of knowing the state, which is
// computed here from the whole model's step. Prints how many states there are, the least and the largest of
// bound minus value, and the largest value. MODEL is the model's type, HEADER its generated header.
#include <cstdio>
#include <cstring>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "hypgen/exact/enumerating_draws.hpp"

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
  }
  std::vector<double> values(places.size(), 0.0);
  for (int sweep = 0; sweep < 2000; ++sweep) {
    for (std::size_t i = 0; i < places.size(); ++i) {
      double best = choices[i].empty() ? 0.0 : -1e30;
      for (const Choice& choice : choices[i]) {
        double value = choice.reward;
        for (const Outcome& o : choice.outcomes) value += discount * o.probability * values[o.next];
        best = value > best ? value : best;
      }
      values[i] = best;
    }
  }
  double least = 1e30, most = -1e30, largest = -1e30;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double over = static_cast<double>(M::upper(params, places[i].fixed, places[i].state)) - values[i];
    least = over < least ? over : least;
    most = over > most ? over : most;
    largest = values[i] > largest ? values[i] : largest;
  }
  std::printf("%zu %.9g %.9g %.9g\n", places.size(), least, most, largest);
  return 0;
}
