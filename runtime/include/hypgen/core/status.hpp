// SPDX-License-Identifier: Apache-2.0
// The ways in which a search, a belief update or an episode ends.
#pragma once

namespace hypgen {

enum class Status {
  kOk,
  kDeadline,               // the time limit ended the search
  kTrialLimit,             // the trial limit ended the search
  kConverged,              // the root's gap is closed
  kMemoryFull,             // an arena is full: the tree stopped growing
  kTerminal,               // the episode reached a terminal state
  kStepLimit,              // the episode reached its last step
  kDepletedBelief,         // no particle explains the observation, and hypotheses have been lost on the way
  kImpossibleObservation,  // no particle explains the observation, though none has been lost
  kAllParticlesTerminal,   // the belief holds that the episode has ended, the world has not
  kNotKept,                // the belief knows nothing of hidden variables, as nothing reads that
  kNoLegalAction,
  kModelNan,       // a bound or return of the model is NaN
  kCrossedBounds,  // the model's upper bound at the root is below what the default policy earns
  kEvaluatorFailed,
  kDeviceLost,  // the GPU failed in mid-search
  kInterrupted,
  kDeadlineDefault,  // the time limit left no search: the default policy acts
  kNoGpu,            // a GPU is required, and there is none that the program can use
  kNoMemory,         // the memory that the options ask for is not to be had
  kWrongArgument,
};

// Whether a search with this status has nothing to go by.
constexpr bool is_failure(Status status) {
  return status == Status::kModelNan || status == Status::kEvaluatorFailed;
}

// The name that tables and JSON lines use.
const char* status_name(Status status);

}  // namespace hypgen
