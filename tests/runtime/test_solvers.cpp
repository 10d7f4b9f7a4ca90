// SPDX-License-Identifier: Apache-2.0
// All that is made of the test models' types: compiled once, as it takes the compiler longest.
#include "test_solvers.hpp"

#include "hypgen/solver/model_instance.hpp"

namespace hypgen::testing {

ModelDescriptor tiger_descriptor() {
  ModelDescriptor model = make_descriptor<Tiger>();
  model.name = "Tiger";
  model.hash = "0";
  model.action_names = {"listen", "open_left", "open_right"};
  model.observation_name = [](KeyWords key) { return std::string(key[0] == 0 ? "left" : "right"); };
  model.params = {{"hearing", ParamKind::kProb, 0.0, 1.0, {}, {0.85F}, {}}};
  return model;
}

template <int N, int K>
ModelDescriptor rock_sample_descriptor() {
  ModelDescriptor model = make_descriptor<RockSample<N, K>>();
  model.name = "RockSample";
  model.hash = "0";
  model.has_success = true;
  model.action_names = {"north", "south", "east", "west", "sample"};
  for (int r = 0; r < K; ++r) model.action_names.push_back("check(" + std::to_string(r) + ")");
  model.observation_name = [](KeyWords key) { return std::to_string(key[0]); };
  return model;
}

template ModelDescriptor rock_sample_descriptor<4, 3>();
template ModelDescriptor rock_sample_descriptor<7, 8>();

ModelDescriptor mishaps_descriptor(double upper, int illegal_from) {
  ModelDescriptor model = make_descriptor<Mishaps>();
  model.name = "Mishaps";
  model.discount = 1.0;
  model.horizon = 5;
  model.action_names = {"zero", "one"};
  model.observation_name = [](KeyWords key) { return std::to_string(key[0]); };
  model.params = {{"upper", ParamKind::kFloat, -1e9, 1e9, {}, {upper}, {}},
                  {"illegal_from", ParamKind::kInt, 0, 9, {}, {static_cast<double>(illegal_from)}, {}}};
  return model;
}

}  // namespace hypgen::testing
