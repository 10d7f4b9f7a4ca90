// SPDX-License-Identifier: Apache-2.0
#include "handles.hpp"

#include <pthread.h>

#include <mutex>

namespace hypgen {

namespace {

// A list needs no memory of its own and no destructor: what a program leaves alive at its end stays so. Few handles
// are alive at a time, each with megabytes behind it.
struct List {
  std::mutex mutex;
  Handled* first = nullptr;
  std::uintptr_t added = 0;
};

List live;

// Each library in a process has a list in another place, and counts from a number that follows from it: a handle of
// one is none of another. The number is odd and they count by two, so that no handle is a null pointer.
std::uintptr_t first_number() {
  constexpr std::uint64_t kSpread = 0x9E3779B97F4A7C15;  // far apart, whatever the distance of two lists
  return static_cast<std::uintptr_t>(reinterpret_cast<std::uintptr_t>(&live) * kSpread | 1);
}

// A fork finds the list whole, and its mutex free.
void lock() { live.mutex.lock(); }
void unlock() { live.mutex.unlock(); }

}  // namespace

void* LiveHandles::add(std::unique_ptr<Handled> object) {
  static const int forks_well = pthread_atfork(&lock, &unlock, &unlock);
  static_cast<void>(forks_well);
  const std::lock_guard<std::mutex> held(live.mutex);
  object->number_ = first_number() + 2 * live.added++;
  object->next_ = live.first;
  live.first = object.release();
  return reinterpret_cast<void*>(live.first->number_);
}

Refusal LiveHandles::find(const void* handle, Handled::Kind kind, Handled*& object) {
  object = live.first;
  const auto number = reinterpret_cast<std::uintptr_t>(handle);
  while (object != nullptr && (object->number_ != number || object->kind_ != kind)) object = object->next_;
  if (object == nullptr) return Refusal::kUnknown;
  const bool is_forked = object->stays_ && object->process_ != getpid();
  return is_forked ? Refusal::kForked : Refusal::kNone;
}

Refusal LiveHandles::take(const void* handle, Handled::Kind kind, Handled*& object) {
  const std::lock_guard<std::mutex> held(live.mutex);
  const Refusal refusal = find(handle, kind, object);
  if (refusal != Refusal::kNone) return refusal;
  return object->is_busy_.exchange(true, std::memory_order_acquire) ? Refusal::kBusy : Refusal::kNone;
}

std::unique_ptr<Handled> LiveHandles::end(Handled& object) {
  const std::lock_guard<std::mutex> held(live.mutex);
  Handled** place = &live.first;
  while (*place != &object) place = &(*place)->next_;
  *place = object.next_;
  return std::unique_ptr<Handled>(&object);
}

Refusal LiveHandles::visit(const void* handle, Handled::Kind kind, void (*use)(Handled&)) {
  const std::lock_guard<std::mutex> held(live.mutex);
  Handled* object = nullptr;
  const Refusal refusal = find(handle, kind, object);
  if (refusal == Refusal::kNone) use(*object);
  return refusal;
}

}  // namespace hypgen
