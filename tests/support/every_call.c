/* SPDX-License-Identifier: Apache-2.0 */
/* Every call of hypgen.h that gives memory, and calls of each kind that are refused, with RockSample's library.
 * Names the line that went wrong. */
#include <math.h>
#include <stdio.h>

#include "rock_sample.h"

static int refused = 0;
static char* text = NULL;
static char* error = NULL;

#define MUST(condition)                \
  do {                                 \
    if (!(condition)) return __LINE__; \
  } while (0)

/* A refusal with its message; the same call may also be made without asking for one. */
#define REFUSED(call)                \
  do {                               \
    MUST((call) >= HYPGEN_FAILED);   \
    MUST(error != NULL && error[0]); \
    hypgen_free(error);              \
    error = NULL;                    \
    ++refused;                       \
  } while (0)

#define GIVES(call)            \
  do {                         \
    MUST((call) == HYPGEN_OK); \
    MUST(text != NULL);        \
    hypgen_free(text);         \
    text = NULL;               \
  } while (0)

static int plans(const hypgen_model* model) {
  hypgen_options options = {sizeof options, "mode=despot trials=20 scenarios=50 memory=64", NULL};
  hypgen_planner* planner = NULL;
  hypgen_decision decision = {0};
  uint64_t key = 0;
  int32_t values[64 * (8 + ROCK_SAMPLE_VISIBLE)];
  decision.size = sizeof decision;
  MUST(hypgen_create(model, &options, &planner, &error) == HYPGEN_OK);
  REFUSED(hypgen_plan(planner, 0.1, &decision, &error));
  REFUSED(hypgen_reset(planner, NULL, 1, 0, &error));
  REFUSED(hypgen_reset_named(planner, "{\"rover.x\": -5}", 0, &error));
  REFUSED(hypgen_reset_named(planner, "{\"rover.x\": ", 0, &error));
  MUST(hypgen_warm_up(planner, 0.0, NULL) < HYPGEN_FAILED);
  MUST(hypgen_reset_named(planner, "{\"rover.x\": 2}", 0, NULL) == HYPGEN_OK);
  REFUSED(hypgen_plan(planner, NAN, &decision, &error));
  MUST(hypgen_plan(planner, NAN, &decision, NULL) >= HYPGEN_FAILED);
  for (int step = 0; step < 3; ++step) {
    MUST(hypgen_plan(planner, 60.0, &decision, NULL) < HYPGEN_FAILED);
    GIVES(hypgen_tree(planner, 2, 3, 100, &text, &error));
    MUST(hypgen_encode_named(planner, "{\"reading\": \"nothing\"}", &key, 1, NULL) == HYPGEN_OK);
    GIVES(hypgen_decode(planner, &key, 1, &text, NULL));
    MUST(hypgen_update(planner, 0, &key, 1, NULL) < HYPGEN_FAILED);
  }
  GIVES(hypgen_info(planner, &text, NULL));
  GIVES(hypgen_belief(planner, &text, NULL));
  MUST(hypgen_sample_belief(planner, 1, 64, values, sizeof values / sizeof values[0], NULL) == HYPGEN_OK);
  REFUSED(hypgen_sample_belief(planner, 1, 64, values, 7, &error));
  REFUSED(hypgen_update(planner, 99, &key, 1, &error));
  REFUSED(hypgen_update(planner, 0, &key, 3, &error));
  REFUSED(hypgen_update_named(planner, 0, "{\"reading\": 3", &error));
  REFUSED(hypgen_update_named(planner, 0, "{\"reading\": \"looks\"}", &error));
  REFUSED(hypgen_encode_named(planner, "[]", &key, 1, &error));
  REFUSED(hypgen_find_action(planner, "sing", &values[0], &error));
  MUST(hypgen_find_action(planner, "sing", &values[0], NULL) >= HYPGEN_FAILED);
  MUST(hypgen_destroy(planner) == HYPGEN_OK);
  MUST(hypgen_destroy(NULL) == HYPGEN_OK);
  return 0;
}

static int refusals(const hypgen_model* model) {
  hypgen_options options = {sizeof options, "scenario=3", NULL};
  hypgen_planner* planner = NULL;
  hypgen_worlds_options worlds_options = {sizeof worlds_options, 0, 0, NULL, NULL};
  hypgen_worlds* worlds = NULL;
  REFUSED(hypgen_create(model, &options, &planner, &error));
  MUST(hypgen_create(model, &options, &planner, NULL) >= HYPGEN_FAILED);
  options.settings = "mode=despot";
  options.params = "{\"sure\": [7";
  REFUSED(hypgen_create(model, &options, &planner, &error));
  options.params = "{\"sure\": 7}";
  REFUSED(hypgen_create(model, &options, &planner, &error));
  options.size = 1;
  REFUSED(hypgen_create(model, &options, &planner, &error));
  REFUSED(hypgen_worlds_create(model, &worlds_options, &worlds, &error));
  worlds_options.count = 1;
  worlds_options.device = "cuda";
  REFUSED(hypgen_worlds_create(model, &worlds_options, &worlds, &error));
  MUST(planner == NULL && worlds == NULL);
  GIVES(hypgen_describe(model, &text, NULL));
  return 0;
}

static int simulates(const hypgen_model* model) {
  enum { kCount = 20 };
  hypgen_worlds_options options = {sizeof options, kCount, 1, NULL, NULL};
  hypgen_worlds* worlds = NULL;
  int32_t actions[kCount] = {0};
  double rewards[kCount];
  uint8_t terminal[kCount];
  hypgen_worlds_results results = {0};
  results.size = sizeof results;
  results.rewards = rewards;
  results.terminal = terminal;
  MUST(hypgen_worlds_create(model, &options, &worlds, &error) == HYPGEN_OK);
  REFUSED(hypgen_worlds_step(worlds, actions, kCount, &results, &error));
  MUST(hypgen_worlds_reset(worlds, NULL, NULL, kCount, NULL) == HYPGEN_OK);
  REFUSED(hypgen_worlds_step(worlds, actions, 3, &results, &error));
  MUST(hypgen_worlds_step(worlds, actions, kCount, &results, NULL) == HYPGEN_OK);
  MUST(hypgen_worlds_destroy(worlds) == HYPGEN_OK);
  return 0;
}

int main(void) {
  const hypgen_model* model = hypgen_model_rock_sample();
  int line = 0;
  for (int i = 0; i < 3 && !line; ++i) {
    line = plans(model);
    if (!line) line = refusals(model);
    if (!line) line = simulates(model);
  }
  if (line) fprintf(stderr, "line %d failed: %s\n", line, error ? error : "no message");
  printf("%d refused\n", refused);
  fflush(stdout); /* a sanitizer that finds something ends the process before this is done */
  return line != 0;
}
