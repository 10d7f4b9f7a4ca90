// SPDX-License-Identifier: Apache-2.0
// The simulated worlds of hypgen.h.
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "../model/input_text.hpp"
#include "c_calls.hpp"
#include "hypgen/episode/worlds.hpp"
#include "hypgen/leaves/device.hpp"
#include "hypgen/model/key_codec.hpp"
#include "hypgen/model/params.hpp"
#include "hypgen/model/start_text.hpp"
#include "hypgen/solver/device_choice.hpp"
#include "hypgen/solver/options.hpp"

namespace hypgen {

// Each library's model refers to it. As it stands here, a linker takes this file out of the runtime's archive too,
// and c_api.cpp, whose functions this file calls. A build defines the version for this file alone.
inline namespace HYPGEN_RUNTIME_ID {
void this_runtime() {}
}  // namespace HYPGEN_RUNTIME_ID

hypgen_status check_model(const hypgen_model* model, char** error) {
  HYPGEN_NEED(model);
  if (model->runtime == &this_runtime) return HYPGEN_OK;
  return wrong("model: belongs to another library; load each by dlopen with RTLD_LOCAL", error);
}

namespace {

constexpr std::size_t kMostWorlds = std::size_t{1} << 24;
constexpr const char* kNoNextEpisode = "there is no next episode: their numbers end at 2^32";

static_assert(Worlds::kNextEpisode == HYPGEN_NEXT_EPISODE);

// What a `hypgen_worlds` stands for.
struct LiveWorlds : Handled {
  static constexpr Kind kKind = Kind::kWorlds;
  static constexpr const char* kIsNull = "worlds: is NULL";
  static constexpr const char* kIsUnknown = "worlds: were destroyed, or another library has made them";
  static constexpr const char* kIsBusy = "worlds: another thread's call is under way";
  static constexpr const char* kIsForked =
      "worlds: are on a GPU of the process that made them, of which this one is a fork";

  LiveWorlds(EmbeddedModel model_of_all, bool on_gpu)
      : Handled(kKind, on_gpu), model(std::move(model_of_all)) {}

  EmbeddedModel model;
  std::size_t count = 0;
  std::unique_ptr<ModelInstance> instance;  // has what the worlds refer to
  std::unique_ptr<Worlds> worlds;
};

Status refuse(std::string text, std::string& error) {
  error = std::move(text);
  return Status::kWrongArgument;
}

// `run` with the worlds, if the caller knows how many they are.
template <class Run>
hypgen_status with_worlds(hypgen_worlds* worlds, std::size_t count, char** error, const Run& run) {
  return with_handle<LiveWorlds>(worlds, error, [&](LiveWorlds& all, std::string& text) {
    if (count == all.count) return run(all, text);
    return refuse("count: expected " + std::to_string(all.count) + ", found " + std::to_string(count), text);
  });
}

// The options as this version has them, from a caller that may know none but the first ones. False if it knows others.
bool read_options(const hypgen_worlds_options& given, hypgen_worlds_options& options) {
  constexpr std::size_t kFirstSize = offsetof(hypgen_worlds_options, device);
  options = {};
  if (given.size != kFirstSize && given.size != sizeof options) return false;
  std::memcpy(&options, &given, given.size);
  return true;
}

// What `device` of the options asks for.
struct WantedDevice {
  DeviceKind kind = DeviceKind::kCpu;
  int index = kFirstDevice;
};

bool read_wanted(const char* text, WantedDevice& wanted, std::string& error) {
  if (text == nullptr) return true;
  if (read_device(text, wanted.kind, wanted.index) && wanted.kind != DeviceKind::kAuto) return true;
  error = "device: expected cpu, cuda or cuda:N, found " + excerpt(text);
  return false;
}

Status make(LiveWorlds& made, const hypgen_worlds_options& options, WantedDevice wanted, std::string& error) {
  if (options.count < 1 || options.count > kMostWorlds)
    return refuse("count: expected 1 to 2^24 worlds, found " + std::to_string(options.count), error);
  const ModelDescriptor& descriptor = made.model.descriptor;
  ParamValues values(descriptor.params);
  if (options.params != nullptr && !read_params(options.params, descriptor.params, values, error))
    return Status::kWrongArgument;
  if (!check_complete(descriptor.params, values, error)) return Status::kWrongArgument;
  made.instance = descriptor.create(values, error);
  if (!made.instance) return Status::kWrongArgument;
  made.count = options.count;
  const KeyCodec codec(made.model.seen, made.model.key_words);
  if (wanted.kind == DeviceKind::kCpu) {
    made.worlds = made.instance->make_worlds(options.seed, made.count, codec.digits());
    return Status::kOk;
  }
  if (find_device(descriptor.device, wanted.index, error)) {
    made.worlds = descriptor.device->make_worlds(made.instance->params(), options.seed, made.count,
                                                 codec.digits(), wanted.index, error);
  }
  return made.worlds ? Status::kOk : Status::kNoGpu;
}

// Why a world does not do its action.
std::string refusal_of(LiveWorlds& worlds, std::size_t world, std::int32_t action) {
  const std::string where = "world " + std::to_string(world) + ": ";
  const std::vector<std::string>& names = worlds.model.descriptor.action_names;
  if (action == Worlds::kNextEpisode) return where + kNoNextEpisode;
  if (action < 0 || static_cast<std::size_t>(action) >= names.size()) {
    return where + "expected an action from 0 to " + std::to_string(names.size() - 1) +
           ", or HYPGEN_NEXT_EPISODE, found " + std::to_string(action);
  }
  std::vector<std::uint8_t> legal(worlds.count * names.size());
  std::string problem;
  if (worlds.worlds->export_legal(legal.data(), problem) != Status::kOk) return where + problem;
  const auto row = legal.begin() + static_cast<std::ptrdiff_t>(world * names.size());
  if (std::any_of(row, row + static_cast<std::ptrdiff_t>(names.size()), [](auto is) { return is != 0; }))
    return where + "action " + names[static_cast<std::size_t>(action)] + " is not legal now";
  return where + "no action is legal: its episode has ended, or none has begun";
}

}  // namespace
}  // namespace hypgen

using hypgen::LiveWorlds;
using hypgen::Status;

extern "C" {

hypgen_status hypgen_worlds_create(const hypgen_model* model, const hypgen_worlds_options* options,
                                   hypgen_worlds** worlds, char** error) {
  if (error != nullptr) *error = nullptr;
  HYPGEN_NEED(worlds);
  *worlds = nullptr;
  HYPGEN_NEED(options);
  const hypgen_status found = hypgen::check_model(model, error);
  if (found != HYPGEN_OK) return found;
  hypgen_worlds_options known;
  if (!hypgen::read_options(*options, known))
    return hypgen::wrong("options: its size is not sizeof(hypgen_worlds_options)", error);
  return hypgen::guarded(error, [&](std::string& text) {
    hypgen::WantedDevice wanted;
    if (!hypgen::read_wanted(known.device, wanted, text)) return Status::kWrongArgument;
    auto made = std::make_unique<LiveWorlds>(model->make(), wanted.kind == hypgen::DeviceKind::kCuda);
    const Status status = hypgen::make(*made, known, wanted, text);
    if (status == Status::kOk)
      *worlds = static_cast<hypgen_worlds*>(hypgen::LiveHandles::add(std::move(made)));
    return status;
  });
}

hypgen_status hypgen_worlds_destroy(hypgen_worlds* worlds) {
  return hypgen::destroy(worlds, LiveWorlds::kKind);
}

hypgen_status hypgen_worlds_seed(hypgen_worlds* worlds, uint64_t seed, char** error) {
  return hypgen::with_handle<LiveWorlds>(
      worlds, error, [&](LiveWorlds& all, std::string& text) { return all.worlds->reseed(seed, text); });
}

hypgen_status hypgen_worlds_start(hypgen_worlds* worlds, const char* start, char** error) {
  return hypgen::with_handle<LiveWorlds>(worlds, error, [&](LiveWorlds& all, std::string& text) {
    hypgen::StartValues values;
    if (start != nullptr && !hypgen::read_start(start, all.model, values, text))
      return Status::kWrongArgument;
    return all.worlds->set_start(std::move(values), text);
  });
}

hypgen_status hypgen_worlds_reset(hypgen_worlds* worlds, const uint8_t* mask, const uint64_t* episodes,
                                  size_t count, char** error) {
  return hypgen::with_worlds(worlds, count, error, [&](LiveWorlds& all, std::string& text) {
    std::size_t refused = count;
    const Status status = all.worlds->reset(mask, episodes, refused, text);
    if (refused < count) {
      text = "world " + std::to_string(refused) + ": ";
      text += episodes == nullptr
                  ? hypgen::kNoNextEpisode
                  : "expected an episode below 2^32, found " + std::to_string(episodes[refused]);
    }
    return status;
  });
}

hypgen_status hypgen_worlds_visible(hypgen_worlds* worlds, int32_t* visible, size_t count, char** error) {
  return hypgen::with_worlds(worlds, count, error, [&](LiveWorlds& all, std::string& text) {
    if (visible == nullptr) return hypgen::refuse("visible: is NULL", text);
    return all.worlds->export_visible(visible, text);
  });
}

hypgen_status hypgen_worlds_legal(hypgen_worlds* worlds, uint8_t* legal, size_t count, char** error) {
  return hypgen::with_worlds(worlds, count, error, [&](LiveWorlds& all, std::string& text) {
    if (legal == nullptr) return hypgen::refuse("legal: is NULL", text);
    return all.worlds->export_legal(legal, text);
  });
}

hypgen_status hypgen_worlds_step(hypgen_worlds* worlds, const int32_t* actions, size_t count,
                                 const hypgen_worlds_results* out, char** error) {
  return hypgen::with_worlds(worlds, count, error, [&](LiveWorlds& all, std::string& text) {
    if (actions == nullptr || out == nullptr) return hypgen::refuse("actions or out: is NULL", text);
    if (out->size != sizeof(hypgen_worlds_results))
      return hypgen::refuse("out: its size is not sizeof(hypgen_worlds_results)", text);
    std::size_t refused = count;
    const Status status = all.worlds->step(
        actions, {out->rewards, out->seen, out->keys, out->visible, out->legal, out->terminal, out->success},
        refused, text);
    if (refused < count) text = hypgen::refusal_of(all, refused, actions[refused]);
    return status;
  });
}

}  // extern "C"
