/* SPDX-License-Identifier: Apache-2.0 */
/* A robot that decides at a fixed rate for a long time, over the C interface: how late are its decisions, and does
 * its memory grow? Usage: soak SECONDS HERTZ BUDGET SETTINGS; a plan has BUDGET seconds from the period's start.
 *
 * The robot senses whether a rock of RockSample is good, and is right 85 times of 100. An episode has 60 steps. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "rock_sample.h"

enum { STEPS = 60, FIRST_CHECK = 5 };

static int compare(const void* a, const void* b) {
  const double first = *(const double*)a, second = *(const double*)b;
  return (first > second) - (first < second);
}

static void report(const char* name, double* values, size_t count) {
  const double shares[] = {0.5, 0.99, 0.999, 1.0};
  qsort(values, count, sizeof *values, compare);
  printf("%s", name);
  for (size_t i = 0; i < sizeof shares / sizeof *shares; ++i)
    printf(" %.3f", 1e3 * values[(size_t)(shares[i] * (double)(count - 1))]);
  printf("\n");
}

/* Pages of this process in memory, in KiB. */
static long resident(void) {
  long pages = 0, all = 0;
  FILE* const file = fopen("/proc/self/statm", "r");
  if (file == NULL) return 0;
  if (fscanf(file, "%ld %ld", &all, &pages) != 2) pages = 0;
  fclose(file);
  return pages * (sysconf(_SC_PAGESIZE) / 1024);
}

static void sleep_until(int64_t time) {
  const struct timespec end = {time / 1000000000, time % 1000000000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &end, NULL) != 0) continue;
}

int main(int argc, char** argv) {
  if (argc != 5) return fprintf(stderr, "usage: soak SECONDS HERTZ BUDGET SETTINGS\n"), 2;
  const double seconds = atof(argv[1]), hertz = atof(argv[2]), budget = atof(argv[3]);
  const size_t count = (size_t)(seconds * hertz);
  double* const late = calloc(count, sizeof *late);
  double* const update = calloc(count, sizeof *update);
  const hypgen_options options = {sizeof options, argv[4], NULL};
  hypgen_planner* planner = NULL;
  char* error = NULL;
  if (late == NULL || update == NULL || count == 0 ||
      hypgen_create(hypgen_model_rock_sample(), &options, &planner, &error) >= HYPGEN_FAILED ||
      hypgen_warm_up(planner, budget, &error) >= HYPGEN_FAILED)
    return fprintf(stderr, "%s\n", error == NULL ? "no memory, or too few decisions" : error), 1;
  const int64_t period = (int64_t)(1e9 / hertz), start = hypgen_now() + period;
  unsigned good = 0;
  int step = STEPS;
  uint64_t episode = 0;
  size_t statuses[HYPGEN_EVALUATOR_FAILED + 1] = {0}, missed = 0;
  long first = 0;
  srand(1);
  for (size_t i = 0; i < count; ++i) {
    const int64_t tick = start + (int64_t)i * period;
    if (step == STEPS) {
      step = 0;
      good = (unsigned)rand();
      if (hypgen_reset(planner, NULL, 0, episode++, &error) >= HYPGEN_FAILED) break;
      if (episode == 10) first = resident();
    }
    ++step;
    sleep_until(tick);
    hypgen_decision decision = {.size = sizeof decision};
    const int64_t end = tick + (int64_t)(budget * 1e9);
    if (hypgen_plan_until(planner, end, &decision, &error) >= HYPGEN_FAILED) break;
    late[i] = (double)(hypgen_now() - end) * 1e-9;
    missed += late[i] > 1e-3;
    ++statuses[decision.status];
    const int rock = decision.action - FIRST_CHECK;
    const int is_wrong = rand() % 100 >= 85,
              looks_good = rock >= 0 && ((good >> rock & 1) ^ (unsigned)is_wrong);
    const int32_t seen[ROCK_SAMPLE_SEEN] = {rock < 0     ? ROCK_SAMPLE_READING_NOTHING
                                            : looks_good ? ROCK_SAMPLE_READING_LOOKS_GOOD
                                                         : ROCK_SAMPLE_READING_LOOKS_BAD};
    const int64_t before = hypgen_now();
    const hypgen_status status =
        hypgen_update_values(planner, decision.action, seen, ROCK_SAMPLE_SEEN, &error);
    if (status >= HYPGEN_FAILED) break;
    update[i] = (double)(hypgen_now() - before) * 1e-9;
    if (status == HYPGEN_ALL_PARTICLES_TERMINAL) step = STEPS; /* the rover has left */
  }
  if (error != NULL) return fprintf(stderr, "%s\n", error), 1;
  printf("milliseconds: p50 p99 p99.9 worst\n");
  report("after the deadline", late, count);
  report("update", update, count);
  printf("decisions more than 1 ms late: %zu of %zu\n", missed, count);
  for (int status = 0; status <= HYPGEN_EVALUATOR_FAILED; ++status)
    if (statuses[status] > 0) printf("%s: %zu\n", hypgen_status_name(status), statuses[status]);
  printf("episodes: %llu\n", (unsigned long long)episode);
  printf("resident after ten episodes: %ld KiB, at the end: %ld KiB\n", first, resident());
  free(late);
  free(update);
  return hypgen_destroy(planner) == HYPGEN_OK ? 0 : 1;
}
