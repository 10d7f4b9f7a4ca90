// SPDX-License-Identifier: Apache-2.0
// Owners of a device's resources: memory, pinned memory of the host, streams and events.
#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>
#include <string>

namespace hypgen::cuda {

// Whether a call worked; otherwise `error` says what it was and why it failed.
inline bool worked(cudaError_t result, const char* what, std::string& error) {
  if (result == cudaSuccess) return true;
  cudaGetLastError();  // errors that do not stick would be blamed on the next call
  error = std::string(what) + ": " + cudaGetErrorString(result);
  return false;
}

// An array that `Release` gives back.
template <class T, cudaError_t (*Release)(void*)>
class Array {
 public:
  Array() = default;
  Array(const Array&) = delete;
  Array& operator=(const Array&) = delete;
  ~Array() {
    if (data_ != nullptr) Release(data_);
  }

  T* get() const { return data_; }
  T& operator[](std::size_t i) const { return data_[i]; }

 protected:
  T* data_ = nullptr;
};

template <class T>
class DeviceArray : public Array<T, &cudaFree> {
 public:
  bool allocate(std::size_t count, std::string& error) {
    return worked(cudaMalloc(reinterpret_cast<void**>(&this->data_), count * sizeof(T)), "GPU memory", error);
  }
};

// Of the host; kernels reach it too, under the same address.
template <class T>
class PinnedArray : public Array<T, &cudaFreeHost> {
 public:
  bool allocate(std::size_t count, std::string& error) {
    return worked(
        cudaHostAlloc(reinterpret_cast<void**>(&this->data_), count * sizeof(T), cudaHostAllocMapped),
        "pinned memory", error);
  }
};

class Stream {
 public:
  Stream() = default;
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  ~Stream() {
    if (stream_ == nullptr) return;
    cudaStreamSynchronize(stream_);
    cudaStreamDestroy(stream_);
  }

  bool make(std::string& error) {
    return worked(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "stream", error);
  }
  cudaStream_t get() const { return stream_; }

 private:
  cudaStream_t stream_ = nullptr;
};

class Event {
 public:
  Event() = default;
  Event(const Event&) = delete;
  Event& operator=(const Event&) = delete;
  ~Event() {
    if (event_ != nullptr) cudaEventDestroy(event_);
  }

  bool make(std::string& error) { return worked(cudaEventCreate(&event_), "event", error); }
  cudaEvent_t get() const { return event_; }

 private:
  cudaEvent_t event_ = nullptr;
};

}  // namespace hypgen::cuda
