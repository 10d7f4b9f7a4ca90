// SPDX-License-Identifier: Apache-2.0
// What a run's lines of JSON and its recording have in common.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "hypgen/model/descriptor.hpp"
#include "hypgen/solver/options.hpp"
#include "hypgen/solver/run_report.hpp"
#include "hypgen/solver/step_details.hpp"

namespace hypgen {

nlohmann::ordered_json run_json(const ModelDescriptor& model, const SolverOptions& options,
                                const std::string& device, std::size_t threads);
nlohmann::ordered_json start_json(const ModelDescriptor& model, const StartRecord& start);
// `details`: null for a line without them.
nlohmann::ordered_json step_json(const ModelDescriptor& model, const StepRecord& step,
                                 const StepDetails* details);
nlohmann::ordered_json episode_json(const ModelDescriptor& model, const EpisodeRecord& episode);

}  // namespace hypgen
