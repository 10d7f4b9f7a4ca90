// SPDX-License-Identifier: Apache-2.0
// The handles that callers of hypgen.h have. A handle is no address but a number that is never used again, so that
// one of what was destroyed, or of another library, is known as such.
#pragma once

#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <memory>

namespace hypgen {

// What a handle stands for.
class Handled {
 public:
  enum class Kind { kPlanner, kWorlds };

  // `stays`: a fork leaves it to its parent, as threads and GPUs stay there.
  Handled(Kind kind, bool stays) : kind_(kind), stays_(stays) {}
  virtual ~Handled() = default;
  Handled(const Handled&) = delete;
  Handled& operator=(const Handled&) = delete;

 private:
  friend class LiveHandles;

  const Kind kind_;
  const bool stays_;
  const pid_t process_ = getpid();
  std::uintptr_t number_ = 0;
  Handled* next_ = nullptr;
  std::atomic<bool> is_busy_{false};
};

// Why a call does not get what a handle stands for.
enum class Refusal { kNone, kUnknown, kBusy, kForked };

// All objects that have been made and not destroyed: the only global variable of the runtime.
class LiveHandles {
 public:
  // The handle of an object, which is alive from now on.
  static void* add(std::unique_ptr<Handled> object);

  // Lets one call have an object for itself, until `give_back` or `end`. In a fork, what stays with the parent is
  // refused.
  static Refusal take(const void* handle, Handled::Kind kind, Handled*& object);
  static void give_back(Handled& object) { object.is_busy_.store(false, std::memory_order_release); }
  static std::unique_ptr<Handled> end(Handled& object);

  // Calls `use` with an object that another call may have, and that is not destroyed meanwhile.
  static Refusal visit(const void* handle, Handled::Kind kind, void (*use)(Handled&));

 private:
  static Refusal find(const void* handle, Handled::Kind kind, Handled*& object);
};

}  // namespace hypgen
