// SPDX-License-Identifier: Apache-2.0
// As much of CUDA as the runtime's kernels use, on a CPU: for tests of what they compute, not of how fast.
//
// A kernel's blocks run one after the other. A thread of a block is a fiber, which runs until it has to wait for others
// of its block or warp. Streams do not wait: each call is done when it returns.
#pragma once

#include <setjmp.h>
#include <ucontext.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#define __host__
#define __device__
#define __global__
#define __shared__ static
#define __grid_constant__
#define __launch_bounds__(...)
#define __noinline__ __attribute__((noinline))
#define CUDART_VERSION 13000

using std::max;
using std::min;

namespace cuda_on_cpu {

constexpr unsigned kWarp = 32;

struct Place {
  unsigned x = 0;
};

// Something that fibers wait for together.
struct Meeting {
  unsigned arrived = 0;
  unsigned long generation = 0;

  bool complete(unsigned expected) {
    if (arrived == 0 || arrived < expected) return false;
    arrived = 0;
    ++generation;
    return true;
  }
};

struct Warp {
  unsigned live = 0;  // a bit a lane
  Meeting meeting;
  std::uint64_t slots[2][kWarp] = {};
};

struct Fiber {
  static constexpr std::size_t kStack = std::size_t{256} << 10;

  std::unique_ptr<unsigned char[]> stack{new unsigned char[kStack]};
  ucontext_t start{};
  jmp_buf at;
  bool begun = false;
  bool ended = false;
  const unsigned long* waits_for = nullptr;
  unsigned long waits_while = 0;
};

struct Machine {
  static constexpr int kBarriers = 2;

  std::vector<Fiber> fibers;
  std::vector<Warp> warps;
  Meeting barriers[kBarriers];
  std::vector<unsigned char> dynamic_shared;
  const std::function<void()>* kernel = nullptr;
  ucontext_t scheduler{};
  jmp_buf scheduler_at;
  unsigned current = 0;
  unsigned alive = 0;
  Place thread, block, block_size, grid_size;

  void run(unsigned blocks, unsigned threads, std::size_t shared, const std::function<void()>& body) {
    if (fibers.size() < threads) fibers.resize(threads);
    dynamic_shared.assign(shared + 16, 0xAB);
    kernel = &body;
    grid_size.x = blocks;
    block_size.x = threads;
    for (block.x = 0; block.x < blocks; ++block.x) run_block(threads);
  }

  void run_block(unsigned threads) {
    alive = threads;
    warps.assign((threads + kWarp - 1) / kWarp, Warp{});
    for (Meeting& barrier : barriers) barrier = {};
    for (unsigned i = 0; i < threads; ++i) {
      fibers[i].begun = fibers[i].ended = false;
      fibers[i].waits_for = nullptr;
      warps[i / kWarp].live |= 1U << i % kWarp;
    }
    while (alive > 0) {
      bool moved = false;
      for (unsigned i = 0; i < threads; ++i) {
        Fiber& fiber = fibers[i];
        if (fiber.ended || (fiber.waits_for != nullptr && *fiber.waits_for == fiber.waits_while)) continue;
        fiber.waits_for = nullptr;
        moved = true;
        resume(i);
      }
      if (!moved) std::abort();  // a barrier that not all threads reach
    }
  }

  void resume(unsigned i) {
    current = i;
    thread.x = i;
    Fiber& fiber = fibers[i];
    if (_setjmp(scheduler_at) != 0) return;
    if (fiber.begun) _longjmp(fiber.at, 1);
    fiber.begun = true;
    getcontext(&fiber.start);
    fiber.start.uc_stack.ss_sp = fiber.stack.get();
    fiber.start.uc_stack.ss_size = Fiber::kStack;
    fiber.start.uc_link = nullptr;
    makecontext(&fiber.start, &Machine::enter, 0);
    setcontext(&fiber.start);
  }

  static void enter();

  void wait(const Meeting& meeting, unsigned long generation) {
    Fiber& fiber = fibers[current];
    if (meeting.generation != generation) return;
    fiber.waits_for = &meeting.generation;
    fiber.waits_while = generation;
    if (_setjmp(fiber.at) == 0) _longjmp(scheduler_at, 1);
  }

  void end() {
    const unsigned i = current;
    Warp& warp = warps[i / kWarp];
    fibers[i].ended = true;
    warp.live &= ~(1U << i % kWarp);
    --alive;
    warp.meeting.complete(static_cast<unsigned>(__builtin_popcount(warp.live)));
    for (Meeting& barrier : barriers) barrier.complete(alive);
    _longjmp(scheduler_at, 1);
  }

  void barrier(int which) {
    Meeting& meeting = barriers[which];
    const unsigned long generation = meeting.generation;
    ++meeting.arrived;
    if (!meeting.complete(alive)) wait(meeting, generation);
  }

  // Gives a value to the warp's lanes, and returns those of all.
  const std::uint64_t* exchange(std::uint64_t value, unsigned& live) {
    Warp& warp = warps[current / kWarp];
    live = warp.live;
    const unsigned long generation = warp.meeting.generation;
    std::uint64_t* const slots = warp.slots[generation % 2];
    slots[current % kWarp] = value;
    ++warp.meeting.arrived;
    if (!warp.meeting.complete(static_cast<unsigned>(__builtin_popcount(live))))
      wait(warp.meeting, generation);
    return slots;
  }
};

inline Machine& machine() {
  static Machine one;
  return one;
}

inline void Machine::enter() {
  (*machine().kernel)();
  machine().end();
}

struct Launch {
  unsigned blocks, threads;
  std::size_t shared;

  template <class Stream = std::nullptr_t>
  Launch(std::size_t grid, std::size_t block, std::size_t shared_bytes = 0, Stream = {})
      : blocks(static_cast<unsigned>(grid)), threads(static_cast<unsigned>(block)), shared(shared_bytes) {}

  void run(const std::function<void()>& kernel) const {
    static std::mutex one_at_a_time;
    const std::lock_guard<std::mutex> lock(one_at_a_time);
    machine().run(blocks, threads, shared, kernel);
  }
};

inline unsigned char* dynamic_shared() {
  const auto at = reinterpret_cast<std::uintptr_t>(machine().dynamic_shared.data());
  return reinterpret_cast<unsigned char*>((at + 15) / 16 * 16);
}

template <class T>
std::uint64_t as_bits(T value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof value);
  return bits;
}

template <class T>
T from_bits(std::uint64_t bits) {
  T value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

}  // namespace cuda_on_cpu

#define threadIdx (cuda_on_cpu::machine().thread)
#define blockIdx (cuda_on_cpu::machine().block)
#define blockDim (cuda_on_cpu::machine().block_size)
#define gridDim (cuda_on_cpu::machine().grid_size)

inline void __syncthreads() { cuda_on_cpu::machine().barrier(0); }
inline void __threadfence_system() {}
inline void __syncwarp() {
  unsigned live;
  cuda_on_cpu::machine().exchange(0, live);
}

inline unsigned __ballot_sync(unsigned, bool holds) {
  unsigned live, votes = 0;
  const std::uint64_t* const all = cuda_on_cpu::machine().exchange(holds, live);
  for (unsigned lane = 0; lane < cuda_on_cpu::kWarp; ++lane)
    votes |= (all[lane] != 0 ? live : 0) & 1U << lane;
  return votes;
}
template <class T>
T __shfl_sync(unsigned, T value, int lane) {
  unsigned live;
  const std::uint64_t* const all = cuda_on_cpu::machine().exchange(cuda_on_cpu::as_bits(value), live);
  return cuda_on_cpu::from_bits<T>(all[lane % 32]);
}
template <class T>
T __shfl_xor_sync(unsigned, T value, unsigned offset) {
  unsigned live;
  const unsigned lane = threadIdx.x % cuda_on_cpu::kWarp;
  const std::uint64_t* const all = cuda_on_cpu::machine().exchange(cuda_on_cpu::as_bits(value), live);
  return cuda_on_cpu::from_bits<T>(all[lane ^ offset]);
}
template <class T>
T __shfl_up_sync(unsigned, T value, unsigned offset) {
  unsigned live;
  const unsigned lane = threadIdx.x % cuda_on_cpu::kWarp;
  const std::uint64_t* const all = cuda_on_cpu::machine().exchange(cuda_on_cpu::as_bits(value), live);
  return lane < offset ? value : cuda_on_cpu::from_bits<T>(all[lane - offset]);
}
template <class T>
unsigned __match_any_sync(unsigned, T value) {
  unsigned live, peers = 0;
  const std::uint64_t mine = cuda_on_cpu::as_bits(value);
  const std::uint64_t* const all = cuda_on_cpu::machine().exchange(mine, live);
  for (unsigned lane = 0; lane < cuda_on_cpu::kWarp; ++lane)
    peers |= (all[lane] == mine ? live : 0) & 1U << lane;
  return peers;
}

inline int __popc(unsigned bits) { return __builtin_popcount(bits); }
inline int __ffs(unsigned bits) { return __builtin_ffs(static_cast<int>(bits)); }

template <class T, class U>
T atomicAdd(T* at, U by) {
  const T before = *at;
  *at = static_cast<T>(before + static_cast<T>(by));
  return before;
}
template <class T, class U>
T atomicSub(T* at, U by) {
  const T before = *at;
  *at = static_cast<T>(before - static_cast<T>(by));
  return before;
}
template <class T, class U>
T atomicOr(T* at, U bits) {
  const T before = *at;
  *at = static_cast<T>(before | static_cast<T>(bits));
  return before;
}
template <class T, class U>
T atomicMin(T* at, U other) {
  const T before = *at;
  *at = std::min(before, static_cast<T>(other));
  return before;
}
template <class T, class U>
T atomicMax(T* at, U other) {
  const T before = *at;
  *at = std::max(before, static_cast<T>(other));
  return before;
}
template <class T, class U>
T atomicCAS(T* at, U expected, U wanted) {
  const T before = *at;
  if (before == static_cast<T>(expected)) *at = static_cast<T>(wanted);
  return before;
}

enum cudaError_t { cudaSuccess, cudaErrorNotReady, cudaErrorInsufficientDriver };
enum cudaMemcpyKind { cudaMemcpyHostToDevice, cudaMemcpyDeviceToHost };
enum { cudaStreamNonBlocking, cudaHostAllocMapped };
enum cudaFuncAttribute { cudaFuncAttributeMaxDynamicSharedMemorySize };
enum cudaDeviceAttr { cudaDevAttrMaxSharedMemoryPerBlockOptin };
struct cuda_on_cpu_stream {};
struct cuda_on_cpu_event {
  std::chrono::steady_clock::time_point time;
};
using cudaStream_t = cuda_on_cpu_stream*;
using cudaEvent_t = cuda_on_cpu_event*;
struct cudaFuncAttributes {};
struct cudaDeviceProp {
  char name[64];
  int major, minor, multiProcessorCount;
  std::size_t totalGlobalMem, sharedMemPerBlockOptin;
};

constexpr std::size_t kSharedBytesOnCpu = std::size_t{200} << 10;
constexpr std::size_t kBytesOnCpu = std::size_t{4} << 30;

inline const char* cudaGetErrorString(cudaError_t) { return "no error"; }
inline cudaError_t cudaGetLastError() { return cudaSuccess; }
inline cudaError_t cudaGetDeviceCount(int* count) { return *count = 1, cudaSuccess; }
inline cudaError_t cudaSetDevice(int) { return cudaSuccess; }
inline cudaError_t cudaGetDevice(int* device) { return *device = 0, cudaSuccess; }
inline cudaError_t cudaDeviceSynchronize() { return cudaSuccess; }
inline cudaError_t cudaDeviceGetAttribute(int* value, cudaDeviceAttr, int) {
  *value = static_cast<int>(kSharedBytesOnCpu);
  return cudaSuccess;
}
inline cudaError_t cudaGetDeviceProperties(cudaDeviceProp* properties, int) {
  *properties = {"CUDA on a CPU", 9, 0, 2, kBytesOnCpu, kSharedBytesOnCpu};
  return cudaSuccess;
}
template <class Kernel>
cudaError_t cudaFuncGetAttributes(cudaFuncAttributes*, Kernel) {
  return cudaSuccess;
}
template <class Kernel>
cudaError_t cudaFuncSetAttribute(Kernel, cudaFuncAttribute, int) {
  return cudaSuccess;
}
template <class Kernel>
cudaError_t cudaOccupancyMaxActiveBlocksPerMultiprocessor(int* blocks, Kernel, int, std::size_t) {
  return *blocks = 1, cudaSuccess;
}
inline cudaError_t cudaMemGetInfo(std::size_t* free_bytes, std::size_t* total) {
  *free_bytes = *total = kBytesOnCpu;
  return cudaSuccess;
}
inline cudaError_t cudaMalloc(void** at, std::size_t bytes) {
  return *at = std::malloc(std::max<std::size_t>(bytes, 1)), cudaSuccess;
}
inline cudaError_t cudaHostAlloc(void** at, std::size_t bytes, unsigned) { return cudaMalloc(at, bytes); }
inline cudaError_t cudaFree(void* at) { return std::free(at), cudaSuccess; }
inline cudaError_t cudaFreeHost(void* at) { return cudaFree(at); }
inline cudaError_t cudaMemcpy(void* to, const void* from, std::size_t bytes, cudaMemcpyKind) {
  return std::memcpy(to, from, bytes), cudaSuccess;
}
inline cudaError_t cudaMemcpyAsync(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind,
                                   cudaStream_t) {
  return cudaMemcpy(to, from, bytes, kind);
}
inline cudaError_t cudaMemset(void* to, int value, std::size_t bytes) {
  return std::memset(to, value, bytes), cudaSuccess;
}
inline cudaError_t cudaMemsetAsync(void* to, int value, std::size_t bytes, cudaStream_t) {
  return cudaMemset(to, value, bytes);
}
inline cudaError_t cudaStreamCreateWithFlags(cudaStream_t* stream, unsigned) {
  return *stream = new cuda_on_cpu_stream, cudaSuccess;
}
inline cudaError_t cudaStreamDestroy(cudaStream_t stream) { return delete stream, cudaSuccess; }
inline cudaError_t cudaStreamSynchronize(cudaStream_t) { return cudaSuccess; }
inline cudaError_t cudaStreamQuery(cudaStream_t) { return cudaSuccess; }
inline cudaError_t cudaEventCreate(cudaEvent_t* event) { return *event = new cuda_on_cpu_event, cudaSuccess; }
inline cudaError_t cudaEventDestroy(cudaEvent_t event) { return delete event, cudaSuccess; }
inline cudaError_t cudaEventRecord(cudaEvent_t event, cudaStream_t = nullptr) {
  return event->time = std::chrono::steady_clock::now(), cudaSuccess;
}
inline cudaError_t cudaEventSynchronize(cudaEvent_t) { return cudaSuccess; }
inline cudaError_t cudaEventElapsedTime(float* milliseconds, cudaEvent_t from, cudaEvent_t to) {
  *milliseconds = std::chrono::duration<float, std::milli>(to->time - from->time).count();
  return cudaSuccess;
}
