// SPDX-License-Identifier: Apache-2.0
// Memory that several threads share: reserved once, taken in chunks, given back all at once.
#pragma once

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

namespace hypgen {

constexpr std::size_t kCacheLine = 64;

// Where a block of a ChunkPool starts, in units of 16 bytes. Fits an atomic word, half of a pointer's.
template <class T>
struct Ref {
  std::uint32_t units = 0;  // 0: none

  explicit operator bool() const { return units != 0; }
  friend bool operator==(Ref a, Ref b) { return a.units == b.units; }
  friend bool operator!=(Ref a, Ref b) { return a.units != b.units; }
};

// One region for all kinds of objects, so that no kind has a share of its own that could be the wrong one.
// Threads take from it through a PoolCursor each; pages that nobody took are never touched.
class ChunkPool {
 public:
  static constexpr std::size_t kUnit = 16;

  ChunkPool(std::size_t bytes, std::size_t threads)
      : capacity_(std::min(bytes, kMostBytes) / kCacheLine * kCacheLine + kFirst),
        chunk_(chunk_for(bytes, threads)),
        region_(reserve(capacity_)) {}

  // Gives all blocks back. Only while no thread takes or reads any; each cursor has to be reset too.
  void reset() { taken_.store(kFirst, std::memory_order_relaxed); }

  template <class T>
  T& operator[](Ref<T> ref) const {
    return *reinterpret_cast<T*>(region_.get() + std::size_t{ref.units} * kUnit);
  }

  std::size_t capacity() const { return capacity_ - kFirst; }
  std::size_t taken() const { return taken_.load(std::memory_order_relaxed) - kFirst; }
  std::size_t chunk_bytes() const { return chunk_; }

 private:
  friend class PoolCursor;

  static constexpr std::size_t kFirst = kCacheLine;  // as offset 0 means none
  static constexpr std::size_t kMostBytes = (std::size_t{UINT32_MAX} - kCacheLine) * kUnit;
  static constexpr std::size_t kHugePage = std::size_t{2} << 20;
  static constexpr std::size_t kLeastChunk = std::size_t{4} << 10;

  struct Free {
    void operator()(unsigned char* region) const { std::free(region); }
  };
  // Bytes of the region.
  struct Range {
    std::size_t next, end;

    std::size_t size() const { return end - next; }
  };

  // What threads hold but do not use yet is at most an eighth, unless chunks would be too small.
  static std::size_t chunk_for(std::size_t bytes, std::size_t threads) {
    std::size_t chunk = kLeastChunk;
    while (chunk < kHugePage && 2 * chunk <= bytes / (8 * threads)) chunk *= 2;
    return chunk;
  }

  static unsigned char* reserve(std::size_t bytes) {
    const std::size_t whole_pages = (bytes + kHugePage - 1) / kHugePage * kHugePage;
    void* const region = std::aligned_alloc(kHugePage, whole_pages);
    if (region == nullptr) throw std::bad_alloc();
#if defined(MADV_HUGEPAGE)
    madvise(region, whole_pages, MADV_HUGEPAGE);  // fewer page faults; works without too
#endif
    return static_cast<unsigned char*>(region);
  }

  // Takes `wanted` bytes, or what is left if that is `least` at least; otherwise nothing. Both are whole
  // lines, so that no two threads write to one.
  Range take(std::size_t least, std::size_t wanted) {
    // Relaxed: it counts and no more. Who reads a block has got its place from whoever published it.
    std::size_t first = taken_.load(std::memory_order_relaxed);
    while (true) {
      const std::size_t left = capacity_ - first;
      if (left < least) return {0, 0};
      const std::size_t end = first + std::min(wanted, left);
      if (taken_.compare_exchange_weak(first, end, std::memory_order_relaxed)) return {first, end};
    }
  }

  std::size_t capacity_;
  std::size_t chunk_;
  std::unique_ptr<unsigned char, Free> region_;
  alignas(kCacheLine) std::atomic<std::size_t> taken_{kFirst};  // on a line of its own: threads write it
};

// One thread's way to take blocks of a pool, in order.
class alignas(kCacheLine) PoolCursor {
 public:
  explicit PoolCursor(ChunkPool& pool) : pool_(&pool) {}

  void reset() { chunk_ = last_ = {0, 0}; }

  // A block of `bytes`, with unspecified contents, that starts with a T; none if the pool is full.
  template <class T>
  Ref<T> take(std::size_t bytes = sizeof(T)) {
    static_assert(std::is_trivially_destructible_v<T> && alignof(T) <= kCacheLine);
    const std::size_t first = round_up(chunk_.next, alignment<T>);
    if (first + bytes > chunk_.end) return ref<T>(take_fresh(bytes));
    last_ = chunk_;
    chunk_.next = first + bytes;
    return ref<T>(first);
  }

  // Takes back the block that was taken last, which nobody else may know.
  template <class T>
  void take_back([[maybe_unused]] Ref<T> block) {
    assert(block == ref<T>(round_up(last_.next, alignment<T>)));
    if (last_.end == chunk_.end || last_.size() > chunk_.size()) chunk_ = last_;
  }

 private:
  template <class T>
  static constexpr std::size_t alignment = std::max(alignof(T), ChunkPool::kUnit);

  static constexpr std::size_t round_up(std::size_t value, std::size_t unit) {
    return (value + unit - 1) / unit * unit;
  }

  template <class T>
  static Ref<T> ref(std::size_t byte) {
    return {static_cast<std::uint32_t>(byte / ChunkPool::kUnit)};
  }

  // From the pool; 0 if it is full. Goes on with whichever chunk has more left.
  std::size_t take_fresh(std::size_t bytes) {
    const std::size_t lines = round_up(bytes, kCacheLine);
    last_ = pool_->take(lines, std::max(lines, pool_->chunk_));
    if (last_.size() == 0) return 0;
    const ChunkPool::Range rest{last_.next + bytes, last_.end};
    if (rest.size() > chunk_.size()) chunk_ = rest;
    return last_.next;
  }

  ChunkPool* pool_;
  ChunkPool::Range chunk_{0, 0};  // in use
  ChunkPool::Range last_{0, 0};   // that the last block was taken from, as it was before
};

}  // namespace hypgen
