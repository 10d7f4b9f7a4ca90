// SPDX-License-Identifier: Apache-2.0
#include "hypgen/core/status.hpp"

namespace hypgen {

const char* status_name(Status status) {
  switch (status) {
    case Status::kOk:
      return "ok";
    case Status::kDeadline:
      return "deadline";
    case Status::kTrialLimit:
      return "trial_limit";
    case Status::kConverged:
      return "converged";
    case Status::kMemoryFull:
      return "memory_full";
    case Status::kTerminal:
      return "terminal";
    case Status::kStepLimit:
      return "step_limit";
    case Status::kDepletedBelief:
      return "depleted_belief";
    case Status::kImpossibleObservation:
      return "impossible_observation";
    case Status::kAllParticlesTerminal:
      return "all_particles_terminal";
    case Status::kNotKept:
      return "not_kept";
    case Status::kNoLegalAction:
      return "no_legal_action";
    case Status::kModelNan:
      return "model_nan";
    case Status::kCrossedBounds:
      return "crossed_bounds";
    case Status::kEvaluatorFailed:
      return "evaluator_failed";
    case Status::kDeviceLost:
      return "device_lost";
    case Status::kInterrupted:
      return "interrupted";
    case Status::kDeadlineDefault:
      return "deadline_default";
    case Status::kNoGpu:
      return "no_gpu";
    case Status::kNoMemory:
      return "no_memory";
    case Status::kWrongArgument:
      return "wrong_argument";
  }
  return "unknown";
}

}  // namespace hypgen
