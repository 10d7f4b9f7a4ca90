// SPDX-License-Identifier: Apache-2.0
// Many simulated worlds on a GPU: a thread for each does what the CPU's loop does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "hypgen/cuda/memory.cuh"
#include "hypgen/episode/worlds.hpp"
#include "hypgen/model/key.hpp"
#include "hypgen/model/start_values.hpp"

namespace hypgen::cuda {

constexpr unsigned kWorldsBlock = 128;

// What the kernels of a call tell the host besides results.
struct WorldsOutcome {
  std::uint32_t refused;  // how many worlds there are from the first refused one on; 0: none is refused
  std::uint32_t faults;   // of the step
};

template <class M>
__global__ void __launch_bounds__(kWorldsBlock) seed_worlds(WorldsPlay<M> play) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < play.count) play.seed(i);
}

template <class M>
__global__ void __launch_bounds__(kWorldsBlock)
    check_episodes(WorldsPlay<M> play, const std::uint8_t* mask, const std::uint64_t* episodes,
                   WorldsOutcome* outcome) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < play.count && !play.can_begin(i, mask, episodes))
    atomicMax(&outcome->refused, static_cast<std::uint32_t>(play.count) - i);
}

template <class M>
__global__ void __launch_bounds__(kWorldsBlock)
    reset_worlds(WorldsPlay<M> play, const std::uint8_t* mask, const std::uint64_t* episodes,
                 const WorldsOutcome* outcome) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < play.count && outcome->refused == 0) play.reset(i, mask, episodes);
}

template <class M>
__global__ void __launch_bounds__(kWorldsBlock)
    check_actions(WorldsPlay<M> play, const std::int32_t* actions, WorldsOutcome* outcome) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < play.count && !play.can_do(i, actions[i]))
    atomicMax(&outcome->refused, static_cast<std::uint32_t>(play.count) - i);
}

template <class M>
__global__ void __launch_bounds__(kWorldsBlock) step_worlds(WorldsPlay<M> play, const std::int32_t* actions,
                                                            WorldsResults results, WorldsOutcome* outcome) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= play.count || outcome->refused != 0) return;
  const std::uint32_t faults = play.step(i, actions[i], results);
  if (faults != 0) atomicOr(&outcome->faults, faults);
}

template <class M>
__global__ void __launch_bounds__(kWorldsBlock) show_worlds(WorldsPlay<M> play, WorldsResults results) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < play.count) play.show(i, results);
}

// The worlds stay on the device. A call copies what it is given up in one piece and its results down in another,
// through pinned memory; its kernels run in a stream of these worlds.
template <class M>
class CudaWorlds final : public Worlds {
 public:
  // Null and `error` if the device, its memory or that of the host does not suffice.
  static std::unique_ptr<CudaWorlds> make(const typename M::Params& params, std::uint64_t seed,
                                          std::size_t count, const std::vector<KeyDigit>& digits, int device,
                                          std::string& error) {
    std::unique_ptr<CudaWorlds> made(new CudaWorlds(count, digits.size(), device));
    if (!made->allocate(error) || !made->fill(params, digits, error)) return nullptr;
    return made->reseed(seed, error) == Status::kOk ? std::move(made) : nullptr;
  }

  ~CudaWorlds() override { cudaSetDevice(device_); }

  Status reseed(std::uint64_t seed, std::string& error) override {
    play_.key = derive(seed, StreamKind::kWorld, 0);
    if (!begin(error)) return Status::kNoGpu;
    seed_worlds<M><<<blocks(), kWorldsBlock, 0, stream_.get()>>>(play_);
    return end(0, error);
  }

  Status set_start(StartValues start, std::string& error) override {
    play_.start = {};
    if (start.given.empty()) return Status::kOk;
    const std::size_t count = start.given.size();
    if (!worked(cudaSetDevice(device_), "GPU", error) ||
        !upload(start_values_.get(), start.values.data(), count, error) ||
        !upload(start_given_.get(), start.given.data(), count, error)) {
      return Status::kNoGpu;
    }
    play_.start = {start_values_.get(), start_given_.get()};
    return Status::kOk;
  }

  Status reset(const std::uint8_t* mask, const std::uint64_t* episodes, std::size_t& refused,
               std::string& error) override {
    const std::uint64_t* const numbers = episodes == nullptr ? nullptr : up_.get();
    const std::uint8_t* const chosen =
        mask == nullptr ? nullptr : reinterpret_cast<std::uint8_t*>(up_.get() + play_.count);
    if (!begin(error) || !send(episodes, 0, error) || !send(mask, play_.count, error)) return Status::kNoGpu;
    check_episodes<M><<<blocks(), kWorldsBlock, 0, stream_.get()>>>(play_, chosen, numbers, outcome());
    reset_worlds<M><<<blocks(), kWorldsBlock, 0, stream_.get()>>>(play_, chosen, numbers, outcome());
    const Status status = end(0, error);
    return status == Status::kOk ? check(refused) : status;
  }

  Status export_visible(std::int32_t* out, std::string& error) override {
    WorldsResults results;
    results.visible = out;
    return show(results, error);
  }

  Status export_legal(std::uint8_t* out, std::string& error) override {
    WorldsResults results;
    results.legal = out;
    return show(results, error);
  }

  Status step(const std::int32_t* actions, const WorldsResults& out, std::size_t& refused,
              std::string& error) override {
    WorldsResults there;
    const std::size_t bytes = place(out, there);
    if (!begin(error) || !send(actions, 0, error)) return Status::kNoGpu;
    const auto* const given = reinterpret_cast<const std::int32_t*>(up_.get());
    check_actions<M><<<blocks(), kWorldsBlock, 0, stream_.get()>>>(play_, given, outcome());
    step_worlds<M><<<blocks(), kWorldsBlock, 0, stream_.get()>>>(play_, given, there, outcome());
    Status status = end(bytes, error);
    if (status == Status::kOk) status = check(refused);
    if (status != Status::kOk) return status;
    take(out, there);
    return status_of(staged_outcome().faults, error);
  }

 private:
  static constexpr std::size_t kLine = 128;  // bytes: each array of results starts a line
  static constexpr std::size_t kUpBytes = sizeof(std::uint64_t) + sizeof(std::uint8_t);  // of a world at most

  CudaWorlds(std::size_t count, std::size_t digit_count, int device) : device_(device) {
    play_.count = count;
    play_.digit_count = digit_count;
  }

  unsigned blocks() const { return static_cast<unsigned>((play_.count + kWorldsBlock - 1) / kWorldsBlock); }

  // Memory --------------------------------------------------------------------------------------------

  bool allocate(std::string& error) {
    const std::size_t count = play_.count, up_words = (count * kUpBytes + 7) / 8;
    std::size_t free = 0, total = 0;
    if (!worked(cudaSetDevice(device_), "GPU", error) ||
        !worked(cudaMemGetInfo(&free, &total), "GPU memory", error)) {
      return false;
    }
    std::size_t down = kLine;
    WorldsResults any;
    each_array(any, any, [&](auto*&, auto*&, std::size_t bytes) { down += lines_for(bytes); });
    const std::size_t needed = count * sizeof(OneWorld<M>) + up_words * 8 + down;
    if (needed > free) {
      error = std::to_string(count) + " worlds need " + std::to_string((needed >> 20) + 1) +
              " MB of GPU memory, of which " + std::to_string(free >> 20) + " MB are free";
      return false;
    }
    return stream_.make(error) && params_.allocate(1, error) && worlds_.allocate(count, error) &&
           digits_.allocate(play_.digit_count, error) && start_values_.allocate(M::kVariableCount, error) &&
           start_given_.allocate(M::kVariableCount, error) && up_.allocate(up_words, error) &&
           staged_up_.allocate(up_words, error) && down_.allocate(down, error) &&
           staged_down_.allocate(down, error);
  }

  bool fill(const typename M::Params& params, const std::vector<KeyDigit>& digits, std::string& error) {
    play_.params = params_.get();
    play_.worlds = worlds_.get();
    play_.digits = digits_.get();
    return upload(params_.get(), &params, 1, error) &&
           upload(digits_.get(), digits.data(), digits.size(), error) &&
           worked(cudaMemsetAsync(worlds_.get(), 0, play_.count * sizeof(OneWorld<M>), stream_.get()),
                  "GPU memory", error);
  }

  // Copies, and waits until `from` may go away.
  template <class T>
  bool upload(T* to, const T* from, std::size_t count, std::string& error) {
    return worked(cudaMemcpyAsync(to, from, count * sizeof(T), cudaMemcpyHostToDevice, stream_.get()), "GPU",
                  error) &&
           worked(cudaStreamSynchronize(stream_.get()), "GPU", error);
  }

  // A call ------------------------------------------------------------------------------------------

  bool begin(std::string& error) {
    return worked(cudaSetDevice(device_), "GPU", error) &&  // of the calling thread
           worked(cudaMemsetAsync(outcome(), 0, sizeof(WorldsOutcome), stream_.get()), "GPU", error);
  }

  // Copies an entry of each world up, if there is one, from word `first` on.
  template <class T>
  bool send(const T* entries, std::size_t first, std::string& error) {
    if (entries == nullptr) return true;
    const std::size_t bytes = play_.count * sizeof(T);
    std::memcpy(staged_up_.get() + first, entries, bytes);
    return worked(cudaMemcpyAsync(up_.get() + first, staged_up_.get() + first, bytes, cudaMemcpyHostToDevice,
                                  stream_.get()),
                  "GPU", error);
  }

  // Waits for the outcome and so many bytes of results.
  Status end(std::size_t bytes, std::string& error) {
    const bool is_done = worked(cudaGetLastError(), "kernel launch", error) &&
                         worked(cudaMemcpyAsync(staged_down_.get(), down_.get(), kLine + bytes,
                                                cudaMemcpyDeviceToHost, stream_.get()),
                                "GPU", error) &&
                         worked(cudaStreamSynchronize(stream_.get()), "GPU", error);
    return is_done ? Status::kOk : Status::kNoGpu;
  }

  Status check(std::size_t& refused) const {
    refused = play_.count - staged_outcome().refused;
    return refused < play_.count ? Status::kWrongArgument : Status::kOk;
  }

  Status show(const WorldsResults& out, std::string& error) {
    WorldsResults there;
    const std::size_t bytes = place(out, there);
    if (!begin(error)) return Status::kNoGpu;
    show_worlds<M><<<blocks(), kWorldsBlock, 0, stream_.get()>>>(play_, there);
    const Status status = end(bytes, error);
    if (status == Status::kOk) take(out, there);
    return status;
  }

  // Results: the outcome, then each array that is wanted ----------------------------------------------

  WorldsOutcome* outcome() const { return reinterpret_cast<WorldsOutcome*>(down_.get()); }
  const WorldsOutcome& staged_outcome() const {
    return *reinterpret_cast<const WorldsOutcome*>(staged_down_.get());
  }

  // The bytes of an array that has so many for each world.
  std::size_t lines_for(std::size_t bytes) const { return (play_.count * bytes + kLine - 1) / kLine * kLine; }

  // Calls `use` with each array of both, and a world's bytes of it.
  template <class Use>
  void each_array(WorldsResults& one, WorldsResults& other, const Use& use) const {
    use(one.rewards, other.rewards, sizeof(double));
    use(one.seen, other.seen, play_.digit_count * sizeof(std::int32_t));
    use(one.keys, other.keys, sizeof(typename M::Key));
    use(one.visible, other.visible, std::size_t{M::kVisibleCount} * sizeof(std::int32_t));
    use(one.legal, other.legal, std::size_t{M::kActionCount});
    use(one.terminal, other.terminal, 1);
    use(one.success, other.success, 1);
  }

  // Sets where the wanted arrays lie on the device; returns how many bytes they take.
  std::size_t place(WorldsResults wanted, WorldsResults& there) const {
    std::size_t used = 0;
    each_array(wanted, there, [&](auto*& array, auto*& its_place, std::size_t bytes) {
      if (array == nullptr) return;
      its_place = reinterpret_cast<std::remove_reference_t<decltype(its_place)>>(down_.get() + kLine + used);
      used += lines_for(bytes);
    });
    return used;
  }

  // Copies the arrays that have come down to where they are wanted.
  void take(WorldsResults wanted, WorldsResults there) const {
    each_array(wanted, there, [&](auto*& array, auto*& its_place, std::size_t bytes) {
      if (array == nullptr) return;
      const std::size_t offset =
          static_cast<std::size_t>(reinterpret_cast<unsigned char*>(its_place) - down_.get());
      std::memcpy(array, staged_down_.get() + offset, play_.count * bytes);
    });
  }

  int device_;
  WorldsPlay<M> play_;
  DeviceArray<typename M::Params> params_;
  DeviceArray<OneWorld<M>> worlds_;
  DeviceArray<KeyDigit> digits_;
  DeviceArray<std::int32_t> start_values_;
  DeviceArray<std::uint8_t> start_given_;
  DeviceArray<std::uint64_t> up_;  // actions, or numbers of episodes and a mask
  PinnedArray<std::uint64_t> staged_up_;
  DeviceArray<unsigned char> down_;
  PinnedArray<unsigned char> staged_down_;
  Stream stream_;  // last: it waits for its work before memory goes
};

}  // namespace hypgen::cuda
