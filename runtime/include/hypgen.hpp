// SPDX-License-Identifier: Apache-2.0
// hypgen.h for C++17: objects that free what they hold, and exceptions.
//
// A member function calls the function of hypgen.h with its name, and takes what that takes; hypgen.h says what it does.
// It throws Error where the call is refused. Values and keys are arrays, vectors or lists in braces. A function that
// fills an array fills the whole of it. All C++ is in this header: a library may come from another compiler.
#pragma once

#include <hypgen.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>

namespace hypgen::api {

// A call that was refused.
class Error : public std::runtime_error {
 public:
  Error(hypgen_status status, const std::string& text) : std::runtime_error(text), status_(status) {}
  hypgen_status status() const noexcept { return status_; }

 private:
  hypgen_status status_;
};

namespace detail {

struct Free {
  void operator()(char* text) const noexcept { hypgen_free(text); }
  void operator()(hypgen_planner* planner) const noexcept { hypgen_destroy(planner); }
  void operator()(hypgen_worlds* worlds) const noexcept { hypgen_worlds_destroy(worlds); }
};

template <class Held>
using Owner = std::unique_ptr<Held, Free>;

// Calls a function whose last argument is for the text of an error.
template <class... Parameters, class... Arguments>
hypgen_status call(hypgen_status (*function)(Parameters...), Arguments... arguments) {
  char* error = nullptr;
  const hypgen_status status = function(arguments..., &error);
  const Owner<char> text(error);
  if (status >= HYPGEN_FAILED) throw Error(status, text ? text.get() : hypgen_status_name(status));
  return status;
}

// Calls a function that gives a text beside that.
template <class... Parameters, class... Arguments>
std::string text_of(hypgen_status (*function)(Parameters...), Arguments... arguments) {
  char* found = nullptr;
  call(function, arguments..., &found);
  return Owner<char>(found).get();
}

// Refuses a library with other functions than those of this program's hypgen.h.
inline void check_interface(std::uint32_t of_library = hypgen_abi_version()) {
  if (of_library == HYPGEN_ABI_VERSION) return;
  throw Error(HYPGEN_WRONG_ARGUMENT, "library: has version " + std::to_string(of_library) +
                                         " of hypgen.h, and the program was compiled with version " +
                                         std::to_string(HYPGEN_ABI_VERSION));
}

// A JSON text that may be left out.
inline const char* json(const std::string& text) { return text.empty() ? nullptr : text.c_str(); }

}  // namespace detail

// hypgen_describe
inline std::string describe(const hypgen_model* model) {
  detail::check_interface();
  return detail::text_of(hypgen_describe, model);
}

// A planner and its belief. It is destroyed when no call is under way.
class Planner {
 public:
  using List = std::initializer_list<std::int32_t>;

  // `settings` and `params` are those of hypgen_options. Without params the model's own values count.
  explicit Planner(const hypgen_model* model, const std::string& settings = "",
                   const std::string& params = "") {
    detail::check_interface();
    const hypgen_options options = {sizeof options, settings.c_str(), detail::json(params)};
    hypgen_planner* made = nullptr;
    detail::call(hypgen_create, model, &options, &made);
    planner_.reset(made);
  }

  // For calls of hypgen.h.
  hypgen_planner* get() const noexcept { return planner_.get(); }

  std::string info() { return text_of(hypgen_info); }

  hypgen_status reset(std::uint64_t episode = 0) {
    return call(hypgen_reset, nullptr, std::size_t{0}, episode);
  }
  template <class Values = List>
  hypgen_status reset_values(const Values& visible, std::uint64_t episode = 0) {
    return call(hypgen_reset, std::data(visible), std::size(visible), episode);
  }
  hypgen_status reset_named(const std::string& visible, std::uint64_t episode = 0) {
    return call(hypgen_reset_named, visible.c_str(), episode);
  }

  hypgen_decision plan(double seconds = 0.0) { return decide(hypgen_plan, seconds); }
  hypgen_decision plan_until(std::chrono::steady_clock::time_point deadline) {
    const auto since = std::chrono::duration_cast<std::chrono::nanoseconds>(deadline.time_since_epoch());
    return decide(hypgen_plan_until, static_cast<std::int64_t>(since.count()));
  }
  void cancel() noexcept { hypgen_cancel(get()); }
  hypgen_status warm_up(double seconds = 0.0) { return call(hypgen_warm_up, seconds); }

  template <class Key>
  hypgen_status update(std::int32_t action, const Key& key) {
    return call(hypgen_update, action, std::data(key), std::size(key));
  }
  template <class Values = List>
  hypgen_status update_values(std::int32_t action, const Values& seen) {
    return call(hypgen_update_values, action, std::data(seen), std::size(seen));
  }
  hypgen_status update_named(std::int32_t action, const std::string& seen) {
    return call(hypgen_update_named, action, seen.c_str());
  }

  template <class Key, class Values = List>
  void encode(const Values& seen, Key& key) {
    call(hypgen_encode, std::data(seen), std::size(seen), std::data(key), std::size(key));
  }
  template <class Key>
  void encode_named(const std::string& seen, Key& key) {
    call(hypgen_encode_named, seen.c_str(), std::data(key), std::size(key));
  }
  template <class Key>
  std::string decode(const Key& key) {
    return text_of(hypgen_decode, std::data(key), std::size(key));
  }

  std::int32_t find_action(const std::string& name) {
    std::int32_t found = 0;
    call(hypgen_find_action, name.c_str(), &found);
    return found;
  }
  const char* action_name(std::int32_t action) {
    const char* found = nullptr;
    call(hypgen_action_name, action, &found);
    return found;
  }

  std::string tree(std::int32_t depth, std::int32_t top, std::int32_t nodes) {
    return text_of(hypgen_tree, depth, top, nodes);
  }
  std::string belief() { return text_of(hypgen_belief); }
  double probability(const std::string& variable, const std::string& value) {
    double found = 0.0;
    call(hypgen_probability, variable.c_str(), value.c_str(), &found);
    return found;
  }
  template <class Values>
  void sample_belief(std::uint64_t seed, std::size_t count, Values& values) {
    call(hypgen_sample_belief, seed, count, std::data(values), std::size(values));
  }

 private:
  template <class... Parameters, class... Arguments>
  hypgen_status call(hypgen_status (*function)(Parameters...), Arguments... arguments) {
    return detail::call(function, get(), arguments...);
  }

  template <class... Parameters, class... Arguments>
  std::string text_of(hypgen_status (*function)(Parameters...), Arguments... arguments) {
    return detail::text_of(function, get(), arguments...);
  }

  template <class... Parameters, class Limit>
  hypgen_decision decide(hypgen_status (*function)(Parameters...), Limit limit) {
    hypgen_decision decision = {};
    decision.size = sizeof decision;
    call(function, limit, &decision);
    return decision;
  }

  detail::Owner<hypgen_planner> planner_;
};

// Simulated worlds. Arrays have rows for all of them, as hypgen.h says. They are destroyed when no call is under way.
class Worlds {
 public:
  Worlds(const hypgen_model* model, std::size_t count, std::uint64_t seed = 0, const std::string& params = "",
         const std::string& device = "cpu")
      : count_(count) {
    detail::check_interface();
    const hypgen_worlds_options options = {sizeof options, count, seed, detail::json(params), device.c_str()};
    hypgen_worlds* made = nullptr;
    detail::call(hypgen_worlds_create, model, &options, &made);
    worlds_.reset(made);
  }

  // For calls of hypgen.h.
  hypgen_worlds* get() const noexcept { return worlds_.get(); }
  std::size_t count() const noexcept { return count_; }

  void seed(std::uint64_t seed) { detail::call(hypgen_worlds_seed, get(), seed); }
  // Without a start the model's own inits count.
  void start(const std::string& start = "") { detail::call(hypgen_worlds_start, get(), detail::json(start)); }
  void reset(const std::uint8_t* mask = nullptr, const std::uint64_t* episodes = nullptr) {
    detail::call(hypgen_worlds_reset, get(), mask, episodes, count_);
  }
  void visible(std::int32_t* visible) { detail::call(hypgen_worlds_visible, get(), visible, count_); }
  void legal(std::uint8_t* legal) { detail::call(hypgen_worlds_legal, get(), legal, count_); }
  hypgen_status step(const std::int32_t* actions, hypgen_worlds_results out) {
    out.size = sizeof out;
    return detail::call(hypgen_worlds_step, get(), actions, count_, &out);
  }

 private:
  std::size_t count_;
  detail::Owner<hypgen_worlds> worlds_;
};

}  // namespace hypgen::api
