// What one model can do on GPUs. Only nvcc reads this header, in the model's own unit.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hypgen/device.hpp"
#include "hypgen/key.hpp"
#include "hypgen/leaf_evaluator.hpp"
#include "hypgen/model.hpp"
#include "hypgen/philox.hpp"

namespace hypgen::cuda {

// What a walk knows of the past.
template <class M>
struct Lane {
  typename M::Fixed fixed;
  typename M::State state;
  typename M::History history;
  typename M::Posterior posterior;
};

template <class M>
HYPGEN_FN void start_lane(const typename M::Params& params, PhiloxDraws draws, Lane<M>& lane) {
  M::init_visible(params, draws, lane.fixed, lane.state);
  M::init_hidden(params, draws, lane.fixed, lane.state);
  M::init_history(params, lane.fixed, lane.state, lane.history);
  M::init_posterior(params, lane.fixed, lane.state, lane.posterior);
}

// Takes the default policy's action and adds up what that gives; false at the end of the episode.
template <class M>
HYPGEN_FN bool walk_lane(const typename M::Params& params, PhiloxDraws draws, Lane<M>& lane, double& sum) {
  const int action = M::default_policy(params, lane.fixed, lane.state, lane.history, draws);
  if (action < 0 || !M::is_legal(params, lane.fixed, lane.state, action)) return false;
  typename M::State next;
  const StepResult result = M::step(params, lane.fixed, lane.state, action, draws, next);
  sum += from_fixed_sum(result.reward) + M::upper(params, lane.fixed, lane.state) +
         M::lower(params, lane.fixed, lane.state, lane.history) + M::tail(params, lane.fixed, lane.state);
  if (result.terminal) return false;
  const typename M::Key key = M::observe(params, lane.fixed, lane.state, action, draws, next);
  typename M::State filtered;
  sum += M::filter(params, lane.fixed, lane.state, action, key, draws, filtered);
  const Lane<M> before = lane;
  M::advance_posterior(params, before.fixed, before.state, action, key, next, before.posterior,
                       lane.posterior);
  M::advance_history(params, before.fixed, before.state, action, key, next, before.history, lane.history);
  lane.state = next;
  return true;
}

template <class M>
__global__ void walk_kernel(const typename M::Params* params, StreamKey key, std::uint32_t steps,
                            double* sums) {
  const std::uint32_t scenario = blockIdx.x * blockDim.x + threadIdx.x;
  Lane<M> lane;
  start_lane<M>(*params, PhiloxDraws(key, scenario, 0), lane);
  double sum = 0.0;
  std::uint32_t step = 0;
  while (step < steps && walk_lane<M>(*params, PhiloxDraws(key, scenario, step), lane, sum)) ++step;
  sums[scenario] = sum;
}

// Says of everything that it is not there yet. The kernel shows that nvcc takes the model's functions.
template <class M>
class ModelDeviceSupport final : public DeviceSupport {
 public:
  static constexpr auto kWalk = &walk_kernel<M>;

  std::vector<DeviceInfo> devices(std::string& error) const override {
    error = kMissing;
    return {};
  }

  std::unique_ptr<LeafEvaluator> make_evaluator(const void*, const EvaluatorOptions&, int,
                                                std::string& error) const override {
    error = kMissing;
    return nullptr;
  }

  bool digests(const void*, const DigestRange&, int, int, std::uint64_t*, std::string& error) const override {
    error = kMissing;
    return false;
  }

 private:
  static constexpr const char* kMissing = "the search on GPUs is not written yet";
};

}  // namespace hypgen::cuda
