// SPDX-License-Identifier: Apache-2.0
// The run as JSON lines, version 1: a header, a line a step, a line an episode, a summary. A model with a first
// observation has a line for the start of each episode too.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "hypgen/core/output.hpp"
#include "hypgen/model/descriptor.hpp"
#include "hypgen/solver/options.hpp"
#include "hypgen/solver/run_report.hpp"
#include "hypgen/solver/step_details.hpp"

namespace hypgen {

// Writes each line as it happens, so that an interrupted run leaves whole lines. None follows one that did not fit.
class JsonLines {
 public:
  explicit JsonLines(const ModelDescriptor& model) : model_(model) {}

  // Lines go to `file`, or to standard output for "-"; without a call nothing is written. False if it cannot
  // be opened.
  bool open(const std::string& file);

  // Whether all lines so far could be written; if not, `output` says why.
  bool ok() const { return out_ == nullptr || out_->ok(); }
  const Output& output() const { return *out_; }

  // Syncs the lines; false if that fails.
  bool close() { return out_ == nullptr || out_->close(); }

  void write_run(const SolverOptions& options, const std::string& device, std::size_t threads);
  void write(const StartRecord& start);  // nothing unless the model has a first observation
  void write(const StepRecord& step, const StepDetails* details = nullptr);
  void write(const EpisodeRecord& episode);
  void write_summary(const RunTotals& totals, const std::vector<std::uint64_t>& leaf_sizes);

 private:
  void write_line(const std::string& text);

  const ModelDescriptor& model_;
  std::unique_ptr<Output> out_;
};

}  // namespace hypgen
