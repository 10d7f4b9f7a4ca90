// SPDX-License-Identifier: Apache-2.0
// A run with all that was true, believed and searched, as JSON lines, version 1: docs/reference/recording.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "hypgen/belief/belief.hpp"
#include "hypgen/core/output.hpp"
#include "hypgen/episode/episode.hpp"
#include "hypgen/episode/world.hpp"
#include "hypgen/model/embedded_model.hpp"
#include "hypgen/model/key_codec.hpp"
#include "hypgen/search/planner.hpp"
#include "hypgen/solver/options.hpp"
#include "hypgen/solver/tree_text.hpp"

namespace hypgen {

// What a recording is made of. All of it outlives the recording.
struct Recorded {
  const EmbeddedModel& model;
  const ModelInstance& believed;  // what the planner plans with
  const World& world;
  const SolverOptions& options;
};

// Writes each line as it happens, so that an interrupted run leaves whole lines. None follows one that did not fit.
class Recording {
 public:
  static constexpr std::size_t kSamples = 200;  // states of a belief
  static constexpr TreeExtent kExtent{TreeExtent::kMostDepth, 50, 5000};

  explicit Recording(const Recorded& recorded)
      : recorded_(recorded), codec_(recorded.model.seen, recorded.model.key_words) {}

  // Without a call nothing is written. False if the file cannot be opened.
  bool open(const std::string& file);
  bool is_open() const { return out_ != nullptr; }

  // Whether all lines so far could be written; if not, `output` says why.
  bool ok() const { return out_ == nullptr || out_->ok(); }
  const Output& output() const { return *out_; }

  // Syncs the lines; false if that fails.
  bool close() { return out_ == nullptr || out_->close(); }

  // `params` are those of the world.
  void write_run(const ParamValues& params, const std::string& device, std::size_t threads);
  void write(const StartRecord& start);

  // Keeps what is to be told of a decision, while world and belief are those that it was made for.
  void keep(const Belief& belief, Planner& planner, const Decision& decision, std::uint64_t episode,
            int step);
  void write(const StepRecord& step);  // the last decision's
  void write(const EpisodeRecord& episode);

 private:
  std::string state() const;
  std::string sampled(const Belief& belief, std::uint64_t episode, int step) const;

  const Recorded recorded_;
  KeyCodec codec_;
  std::unique_ptr<Output> out_;
  std::string kept_;  // members of a step's object, as text
};

}  // namespace hypgen
