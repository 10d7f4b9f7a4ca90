// SPDX-License-Identifier: Apache-2.0
// What the functions of hypgen.h share: refusals, and the wall that exceptions do not pass.
#pragma once

#include <hypgen.h>

#include <cstring>
#include <exception>
#include <new>
#include <string>

#include "handles.hpp"
#include "hypgen/core/status.hpp"
#include "hypgen/embed/c_api.hpp"

namespace hypgen {

// Makes no string: there may be no memory for one.
inline hypgen_status fail(hypgen_status status, const char* text, char** error) noexcept {
  if (error != nullptr) *error = strdup(text);
  return status;
}

inline hypgen_status wrong(const char* text, char** error) noexcept {
  return fail(HYPGEN_WRONG_ARGUMENT, text, error);
}

// Calls `run`, which gives a Status and writes an error's text, and lets no exception out.
template <class Run>
hypgen_status guarded(char** error, const Run& run) {
  try {
    std::string text;
    const Status status = run(text);
    const hypgen_status code = code_of(status);
    if (code < HYPGEN_FAILED) return code;
    return fail(code, text.empty() ? status_name(status) : text.c_str(), error);
  } catch (const std::bad_alloc&) {
    return fail(HYPGEN_NO_MEMORY, "not enough memory", error);
  } catch (const std::exception& problem) {
    return fail(HYPGEN_INTERNAL_ERROR, problem.what(), error);
  } catch (...) {
    return fail(HYPGEN_INTERNAL_ERROR, "unknown exception", error);
  }
}

// Refuses a null pointer that stands for something.
#define HYPGEN_NEED(argument) \
  if ((argument) == nullptr) return hypgen::wrong(#argument ": is NULL", error)

// Calls `run` as `guarded` does, with what a handle stands for, which no other call has meanwhile.
template <class Object, class Run>
hypgen_status with_handle(const void* handle, char** error, const Run& run) {
  if (error != nullptr) *error = nullptr;
  if (handle == nullptr) return wrong(Object::kIsNull, error);
  Handled* found = nullptr;
  switch (LiveHandles::take(handle, Object::kKind, found)) {
    case Refusal::kUnknown:
      return wrong(Object::kIsUnknown, error);
    case Refusal::kForked:
      return wrong(Object::kIsForked, error);
    case Refusal::kBusy:
      return fail(HYPGEN_BUSY, Object::kIsBusy, error);
    case Refusal::kNone:
      break;
  }
  auto& object = static_cast<Object&>(*found);
  const hypgen_status status = guarded(error, [&](std::string& text) { return run(object, text); });
  LiveHandles::give_back(object);
  return status;
}

// Destroys what a handle stands for. A fork leaves that to its parent.
inline hypgen_status destroy(const void* handle, Handled::Kind kind) {
  if (handle == nullptr) return HYPGEN_OK;
  Handled* found = nullptr;
  switch (LiveHandles::take(handle, kind, found)) {
    case Refusal::kUnknown:
      return HYPGEN_WRONG_ARGUMENT;
    case Refusal::kForked:
      return HYPGEN_OK;
    case Refusal::kBusy:
      return HYPGEN_BUSY;
    case Refusal::kNone:
      break;
  }
  return guarded(nullptr, [&](std::string&) {
    LiveHandles::end(*found);
    return Status::kOk;
  });
}

// Refuses the model of another library. It stands in the file that has the runtime's version.
hypgen_status check_model(const hypgen_model* model, char** error);

}  // namespace hypgen
