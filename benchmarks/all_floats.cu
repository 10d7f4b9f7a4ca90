// SPDX-License-Identifier: Apache-2.0
// all_floats FUNCTION FIRST COUNT: what tests/support/float_hash_main.cpp prints, computed on the GPU.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "hypgen/math/scalar_functions.hpp"

namespace {

constexpr const char* kNames[] = {"sqrt", "exp", "exp2", "log", "log2", "sin", "cos", "tan", "asin", "acos"};
constexpr int kFunctions = 10;

template <int kFunction>
__device__ float apply(float x) {
  namespace math = hypgen::math;
  if constexpr (kFunction == 0) return math::sqrt(x);
  if constexpr (kFunction == 1) return math::exp(x);
  if constexpr (kFunction == 2) return math::exp2(x);
  if constexpr (kFunction == 3) return math::log(x);
  if constexpr (kFunction == 4) return math::log2(x);
  if constexpr (kFunction == 5) return math::sin(x);
  if constexpr (kFunction == 6) return math::cos(x);
  if constexpr (kFunction == 7) return math::tan(x);
  if constexpr (kFunction == 8) return math::asin(x);
  return math::acos(x);
}

template <int kFunction>
__global__ void hash(std::uint32_t first, unsigned long long* sums) {
  const std::uint64_t i = std::uint64_t{blockIdx.x} * blockDim.x + threadIdx.x;
  const std::uint64_t bits = (std::uint64_t{first + blockIdx.y} << 20) | i;
  const float x = hypgen::math::from_bits(static_cast<std::uint32_t>(bits));
  const std::uint64_t value = hypgen::math::canonical_bits(apply<kFunction>(x));
  atomicAdd(&sums[blockIdx.y], (value + 1) * ((2 * i + 1) * 0x9E3779B97F4A7C15U));
}

using Launch = void (*)(std::uint32_t, unsigned, unsigned long long*);

template <int kFunction>
void launch(std::uint32_t first, unsigned count, unsigned long long* sums) {
  hash<kFunction><<<dim3((1U << 20) / 256, count), 256>>>(first, sums);
}

constexpr Launch kLaunches[kFunctions] = {launch<0>, launch<1>, launch<2>, launch<3>, launch<4>,
                                          launch<5>, launch<6>, launch<7>, launch<8>, launch<9>};

bool failed(cudaError_t status) {
  if (status == cudaSuccess) return false;
  std::fprintf(stderr, "all_floats: %s\n", cudaGetErrorString(status));
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const auto first = static_cast<std::uint32_t>(std::atoi(argv[2]));
  const auto count = static_cast<unsigned>(std::atoi(argv[3]));
  for (int f = 0; f < kFunctions; ++f) {
    if (std::strcmp(kNames[f], argv[1]) != 0) continue;
    unsigned long long* sums = nullptr;
    std::vector<unsigned long long> found(count);
    const std::size_t bytes = count * sizeof(unsigned long long);
    if (failed(cudaMalloc(&sums, bytes)) || failed(cudaMemset(sums, 0, bytes))) return 1;
    kLaunches[f](first, count, sums);
    if (failed(cudaMemcpy(found.data(), sums, bytes, cudaMemcpyDeviceToHost))) return 1;
    if (failed(cudaFree(sums))) return 1;
    for (const unsigned long long sum : found) std::printf("%016llx\n", sum);
    return 0;
  }
  return 2;
}
