// SPDX-License-Identifier: Apache-2.0
// The simulated worlds of hypgen.h.
#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "c_calls.hpp"
#include "hypgen/embed/key_codec.hpp"
#include "hypgen/episode/worlds.hpp"
#include "hypgen/model/params.hpp"
#include "hypgen/model/start_text.hpp"

namespace hypgen {

// Each library's model refers to it. As it stands here, a linker takes this file out of the runtime's archive too,
// and c_api.cpp, whose functions this file calls.
inline namespace HYPGEN_RUNTIME_ID {
void this_runtime() {}
}  // namespace HYPGEN_RUNTIME_ID

namespace {

constexpr std::size_t kMostWorlds = std::size_t{1} << 24;

static_assert(Worlds::kNextEpisode == HYPGEN_NEXT_EPISODE);

// What a `hypgen_worlds` stands for.
struct LiveWorlds : Handled {
  static constexpr Kind kKind = Kind::kWorlds;
  static constexpr const char* kIsNull = "worlds: is NULL";
  static constexpr const char* kIsUnknown = "worlds: were destroyed, or another library has made them";
  static constexpr const char* kIsBusy = "worlds: another thread's call is under way";

  explicit LiveWorlds(EmbeddedModel model_of_all)
      : Handled(kKind), model(std::move(model_of_all)), codec(model.seen, model.key_words) {}

  EmbeddedModel model;
  KeyCodec codec;
  std::size_t count = 0;
  std::unique_ptr<ModelInstance> instance;  // has what the worlds refer to
  std::unique_ptr<Worlds> worlds;
  std::vector<std::uint64_t> keys;  // of the step, where the caller has no place for them
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

Status make(LiveWorlds& made, const hypgen_worlds_options& options, std::string& error) {
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
  made.worlds = made.instance->make_worlds(options.seed, made.count);
  made.keys.resize(made.count * made.codec.words());
  return Status::kOk;
}

// Why a world does not do its action.
std::string refusal_of(const LiveWorlds& worlds, std::size_t world, std::int32_t action) {
  const std::string where = "world " + std::to_string(world) + ": ";
  const std::vector<std::string>& names = worlds.model.descriptor.action_names;
  if (action == Worlds::kNextEpisode) return where + "there is no next episode: their numbers end at 2^32";
  if (action < 0 || static_cast<std::size_t>(action) >= names.size()) {
    return where + "expected an action from 0 to " + std::to_string(names.size() - 1) +
           ", or HYPGEN_NEXT_EPISODE, found " + std::to_string(action);
  }
  std::vector<std::uint8_t> legal(worlds.count * names.size());
  worlds.worlds->export_legal(legal.data());
  const auto row = legal.begin() + static_cast<std::ptrdiff_t>(world * names.size());
  if (std::any_of(row, row + static_cast<std::ptrdiff_t>(names.size()), [](auto is) { return is != 0; }))
    return where + "action " + names[static_cast<std::size_t>(action)] + " is not legal now";
  return where + "no action is legal: its episode has ended, or none has begun";
}

// Writes the values of what each world has shown.
Status write_seen(LiveWorlds& worlds, const std::uint64_t* keys, std::int32_t* out, std::string& error) {
  const std::size_t words = worlds.codec.words();
  for (std::size_t i = 0; i < worlds.count; ++i, out += worlds.codec.values()) {
    if (!worlds.codec.decode({keys + i * words, words}, out))
      return refuse("world " + std::to_string(i) + ": its model made a key that has no values", error);
  }
  return Status::kOk;
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
  if (options->size != sizeof(hypgen_worlds_options))
    return hypgen::wrong("options: its size is not sizeof(hypgen_worlds_options)", error);
  return hypgen::guarded(error, [&](std::string& text) {
    auto made = std::make_unique<LiveWorlds>(model->make());
    const Status status = hypgen::make(*made, *options, text);
    if (status == Status::kOk)
      *worlds = static_cast<hypgen_worlds*>(hypgen::LiveHandles::add(std::move(made)));
    return status;
  });
}

hypgen_status hypgen_worlds_destroy(hypgen_worlds* worlds) {
  return hypgen::destroy(worlds, LiveWorlds::kKind);
}

hypgen_status hypgen_worlds_seed(hypgen_worlds* worlds, uint64_t seed, char** error) {
  return hypgen::with_handle<LiveWorlds>(worlds, error, [&](LiveWorlds& all, std::string&) {
    all.worlds->reseed(seed);
    return Status::kOk;
  });
}

hypgen_status hypgen_worlds_start(hypgen_worlds* worlds, const char* start, char** error) {
  return hypgen::with_handle<LiveWorlds>(worlds, error, [&](LiveWorlds& all, std::string& text) {
    hypgen::StartValues values;
    if (start != nullptr && !hypgen::read_start(start, all.model, values, text))
      return Status::kWrongArgument;
    all.worlds->set_start(std::move(values));
    return Status::kOk;
  });
}

hypgen_status hypgen_worlds_reset(hypgen_worlds* worlds, const uint8_t* mask, const uint64_t* episodes,
                                  size_t count, char** error) {
  return hypgen::with_worlds(worlds, count, error, [&](LiveWorlds& all, std::string& text) {
    for (std::size_t i = 0; i < count; ++i) {
      if (mask != nullptr && mask[i] == 0) continue;
      const std::uint64_t number = episodes != nullptr ? episodes[i] : all.worlds->next_episode(i);
      if (number < hypgen::Worlds::kMostEpisodes) continue;
      return hypgen::refuse(
          "world " + std::to_string(i) + ": expected an episode below 2^32, found " + std::to_string(number),
          text);
    }
    all.worlds->reset(mask, episodes);
    return Status::kOk;
  });
}

hypgen_status hypgen_worlds_visible(hypgen_worlds* worlds, int32_t* visible, size_t count, char** error) {
  return hypgen::with_worlds(worlds, count, error, [&](LiveWorlds& all, std::string& text) {
    if (visible == nullptr) return hypgen::refuse("visible: is NULL", text);
    all.worlds->export_visible(visible);
    return Status::kOk;
  });
}

hypgen_status hypgen_worlds_legal(hypgen_worlds* worlds, uint8_t* legal, size_t count, char** error) {
  return hypgen::with_worlds(worlds, count, error, [&](LiveWorlds& all, std::string& text) {
    if (legal == nullptr) return hypgen::refuse("legal: is NULL", text);
    all.worlds->export_legal(legal);
    return Status::kOk;
  });
}

hypgen_status hypgen_worlds_step(hypgen_worlds* worlds, const int32_t* actions, size_t count,
                                 const hypgen_worlds_results* out, char** error) {
  return hypgen::with_worlds(worlds, count, error, [&](LiveWorlds& all, std::string& text) {
    if (actions == nullptr || out == nullptr) return hypgen::refuse("actions or out: is NULL", text);
    if (out->size != sizeof(hypgen_worlds_results))
      return hypgen::refuse("out: its size is not sizeof(hypgen_worlds_results)", text);
    const std::size_t refused = all.worlds->find_refusal(actions);
    if (refused < count) return hypgen::refuse(hypgen::refusal_of(all, refused, actions[refused]), text);
    std::uint64_t* const keys = out->keys == nullptr ? all.keys.data() : out->keys;
    const bool has_rewards = all.worlds->step(
        actions, {out->rewards, keys, out->visible, out->legal, out->terminal, out->success});
    if (out->seen != nullptr) {
      const Status status = hypgen::write_seen(all, keys, out->seen, text);
      if (status != Status::kOk) return status;
    }
    return has_rewards ? Status::kOk : Status::kModelNan;
  });
}

}  // extern "C"
