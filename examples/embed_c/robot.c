/* SPDX-License-Identifier: Apache-2.0 */
/* A robot's loop in C: prints what to do, and reads "good", "bad" or "nothing" as what the robot then saw. */
#include <stdio.h>
#include <string.h>

#include "rock_sample.h"

static int fail(const char* call, char* error) {
  fprintf(stderr, "%s: %s\n", call, error ? error : "failed");
  hypgen_free(error);
  return 1;
}

int main(void) {
  const hypgen_options options = {sizeof options, "mode=despot trials=300 scenarios=200 seed=7", NULL};
  hypgen_planner* planner = NULL;
  char* error = NULL;
  if (hypgen_create(hypgen_model_rock_sample(), &options, &planner, &error) >= HYPGEN_FAILED)
    return fail("create", error);
  if (hypgen_reset(planner, NULL, 0, 0, &error) >= HYPGEN_FAILED) return fail("reset", error);
  char line[80];
  for (int step = 0; step < 20; ++step) {
    hypgen_decision decision = {.size = sizeof decision};
    if (hypgen_plan(planner, 0.1, &decision, &error) >= HYPGEN_FAILED) return fail("plan", error);
    printf("%s (%s)\n", decision.action_name, hypgen_status_name(decision.status));
    fflush(stdout);
    if (fgets(line, sizeof line, stdin) == NULL) break;
    const int32_t seen[ROCK_SAMPLE_SEEN] = {strncmp(line, "good", 4) == 0  ? ROCK_SAMPLE_READING_LOOKS_GOOD
                                            : strncmp(line, "bad", 3) == 0 ? ROCK_SAMPLE_READING_LOOKS_BAD
                                                                           : ROCK_SAMPLE_READING_NOTHING};
    if (hypgen_update_values(planner, decision.action, seen, ROCK_SAMPLE_SEEN, &error) >= HYPGEN_FAILED)
      return fail("update", error);
  }
  double good = 0.0;
  if (hypgen_probability(planner, "rock.good[0]", "true", &good, &error) >= HYPGEN_FAILED)
    return fail("probability", error);
  printf("rock 0 is good with probability %.2f\n", good);
  return hypgen_destroy(planner) == HYPGEN_OK ? 0 : 1;
}
