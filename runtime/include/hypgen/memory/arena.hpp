// SPDX-License-Identifier: Apache-2.0
// Memory that is reserved once, handed out in order and given back all at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

namespace hypgen {

// An array of trivial `T` of fixed capacity. Pages that are never handed out are never touched.
template <class T>
class Arena {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  static constexpr std::uint32_t kFull = UINT32_MAX;

  explicit Arena(std::size_t capacity)
      : capacity_(capacity < kFull ? static_cast<std::uint32_t>(capacity) : kFull - 1),
        items_(static_cast<T*>(std::malloc(sizeof(T) * (capacity_ ? capacity_ : 1)))) {
    if (!items_) throw std::bad_alloc();
  }

  // The index of the first of `count` consecutive items with unspecified contents, or kFull.
  std::uint32_t allocate(std::size_t count) {
    if (count > capacity_ - size_) return kFull;
    const std::uint32_t first = size_;
    size_ += static_cast<std::uint32_t>(count);
    return first;
  }

  bool fits(std::size_t count) const { return count <= capacity_ - size_; }
  void reset() { size_ = 0; }
  std::uint32_t size() const { return size_; }
  std::uint32_t capacity() const { return capacity_; }
  T& operator[](std::size_t i) { return items_.get()[i]; }
  const T& operator[](std::size_t i) const { return items_.get()[i]; }

 private:
  struct Free {
    void operator()(T* items) const { std::free(items); }
  };

  std::uint32_t capacity_;
  std::uint32_t size_ = 0;
  std::unique_ptr<T, Free> items_;
};

}  // namespace hypgen
