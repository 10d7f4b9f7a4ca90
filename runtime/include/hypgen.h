/* SPDX-License-Identifier: Apache-2.0 */
/* Planners of generated models for C, and for whatever calls C.
 *
 * `hypgen compile --library` makes a library with one model. Its header <model>.h declares the function that
 * gives the model. All other functions are here, and know no model.
 *
 * - Every call gives a status. From HYPGEN_FAILED on, a call has done nothing of what it was asked for. But after
 *   HYPGEN_NO_MEMORY and HYPGEN_INTERNAL_ERROR of a reset, warm-up or update there is no episode: reset.
 * - `error` may be NULL. Otherwise *error becomes NULL, or a text that says what is wrong where the status is
 *   HYPGEN_FAILED or above. The caller frees it by hypgen_free, and texts from `char**` arguments too.
 * - No exception leaves a call, and no call prints or ends the process.
 * - A planner takes one call at a time: a second thread's call is refused with HYPGEN_BUSY. Several planners
 *   may be at work at the same time.
 * - A call with a handle that was destroyed, or that another library has made, is refused with
 *   HYPGEN_WRONG_ARGUMENT.
 * - A process that forks leaves its planners to the parent: the child's calls are refused.
 * - Arrays and texts that a call takes are read during the call alone.
 * - Only hypgen_create and the first step reserve memory for planning. Later plans and updates allocate nothing,
 *   but where a belief moves its particles, and resamples at a step where no episode before has. Calls with JSON
 *   texts allocate while they run.
 *
 * Values are 32-bit integers: whole numbers as they are, bools as 0 and 1, enums as codes, floats as the bits
 * of a float. Several values come in the order of the model's description, arrays row by row.
 */
#ifndef HYPGEN_H
#define HYPGEN_H

#include <stddef.h>
#include <stdint.h>

#define HYPGEN_ABI_VERSION 1 /* grows where a program has to be compiled again */
#define HYPGEN_API __attribute__((visibility("default")))

#ifdef __cplusplus
extern "C" {
#endif

typedef enum hypgen_status {
  HYPGEN_OK = 0,
  /* How a plan ended. Each of these comes with a legal action. */
  HYPGEN_CONVERGED = 1,        /* the bounds at the root have met */
  HYPGEN_TRIAL_LIMIT = 2,      /* the trials that the settings allow are done */
  HYPGEN_DEADLINE = 3,         /* the time is up */
  HYPGEN_DEADLINE_DEFAULT = 4, /* the time left no search: the default policy's action */
  HYPGEN_MEMORY_FULL = 5,      /* the tree has filled its memory */
  HYPGEN_GPU_LOST = 6,         /* the GPU failed: the default policy's action; later plans use the CPU */
  HYPGEN_MODEL_NAN = 7,        /* a bound or reward is no number: the default policy's action */
  HYPGEN_BOUNDS_CROSSED = 8,   /* the model's upper bound is below what its default policy earns */
  HYPGEN_EVALUATOR_FAILED = 9, /* leaves were not expanded: the default policy's action */
  /* What a belief makes of what was seen. It has moved on all the same. */
  HYPGEN_BELIEF_DEPLETED = 20,        /* no particle explains it, and hypotheses have been lost */
  HYPGEN_IMPOSSIBLE_OBSERVATION = 21, /* no state explains it */
  HYPGEN_ALL_PARTICLES_TERMINAL = 22, /* the belief holds that the episode has ended */
  /* Refusals. */
  HYPGEN_FAILED = 100,
  HYPGEN_WRONG_ARGUMENT = 100,
  HYPGEN_NO_LEGAL_ACTION = 101,
  HYPGEN_NO_GPU = 102,    /* one is asked for that cannot be used; of worlds: or theirs has failed */
  HYPGEN_NO_MEMORY = 103, /* the memory that the settings ask for is not to be had */
  HYPGEN_BUSY = 104,      /* another thread's call is under way */
  HYPGEN_INTERNAL_ERROR = 105
} hypgen_status;

typedef struct hypgen_model hypgen_model;     /* lives as long as its library */
typedef struct hypgen_planner hypgen_planner; /* a planner and its belief */

typedef struct hypgen_options {
  size_t size; /* sizeof(hypgen_options) */
  /* Options of the model's solver about planning, without their dashes, between blanks, such as
   * "mode=despot time=0.05 scenarios=200 seed=7". NULL: the solver's defaults. */
  const char* settings;
  const char* params; /* a JSON object that sets the model's params; NULL: the model's own values */
} hypgen_options;

typedef struct hypgen_decision {
  size_t size;             /* sizeof(hypgen_decision), set by the caller */
  int32_t action;          /* -1: no action is legal */
  int32_t status;          /* what hypgen_plan returned */
  const char* action_name; /* a view, valid until the planner is destroyed; NULL without an action */
  /* Bounds of what the belief is worth; NaN where nothing was searched. Where scenarios part they are less a
   * penalty for each node of the policy's tree (the setting pruning). */
  double lower;
  double upper;
  double seconds; /* of the whole plan */
  uint64_t trials;
  uint64_t expansions;
  uint64_t scenarios; /* of the tree; 0: no tree has looked ahead */
  int32_t max_depth;
  int32_t unused;
} hypgen_decision;

HYPGEN_API uint32_t hypgen_abi_version(void); /* HYPGEN_ABI_VERSION of the library */
HYPGEN_API const char* hypgen_status_name(int32_t status);
HYPGEN_API void hypgen_free(char* text);

/* The model of a shared library that was loaded by dlopen. */
HYPGEN_API const hypgen_model* hypgen_library_model(void);

/* The model as a JSON object: names, types, actions, params, hash, compiler. */
HYPGEN_API hypgen_status hypgen_describe(const hypgen_model* model, char** json, char** error);

/* Makes a planner; `options` may be NULL. */
HYPGEN_API hypgen_status hypgen_create(const hypgen_model* model, const hypgen_options* options,
                                       hypgen_planner** planner, char** error);
/* Does nothing where `planner` is NULL, busy or destroyed; the last is HYPGEN_WRONG_ARGUMENT. */
HYPGEN_API hypgen_status hypgen_destroy(hypgen_planner* planner);

/* The planner as a JSON object: mode, threads, device, and why that is no GPU where one was asked for. Each of its
 * "units" is a part of the belief: particles, effective sample size, distinct values, surprise in bits. */
HYPGEN_API hypgen_status hypgen_info(hypgen_planner* planner, char** json, char** error);

/* Starts an episode. `visible` has the values of all visible variables. It may be NULL, with a count of 0, if the
 * model draws none of them. The episode's number names the random numbers of belief and search. */
HYPGEN_API hypgen_status hypgen_reset(hypgen_planner* planner, const int32_t* visible, size_t count,
                                      uint64_t episode, char** error);
/* The same with a JSON object by name. Variables that the model does not draw may be left out. */
HYPGEN_API hypgen_status hypgen_reset_named(hypgen_planner* planner, const char* visible, uint64_t episode,
                                            char** error);

/* Decides within so many seconds; 0: within the settings' time, or what the last update left of their period. */
HYPGEN_API hypgen_status hypgen_plan(hypgen_planner* planner, double seconds, hypgen_decision* decision,
                                     char** error);

/* The same until a time of the monotonic clock in nanoseconds, as hypgen_now gives it. */
HYPGEN_API hypgen_status hypgen_plan_until(hypgen_planner* planner, int64_t deadline,
                                           hypgen_decision* decision, char** error);
HYPGEN_API int64_t hypgen_now(void);

/* Ends the plan that another thread has under way, as its deadline would; does nothing if there is none. Any
 * thread may call this at any time before hypgen_destroy. A call that comes before the plan has begun does nothing:
 * repeat it until the plan returns. */
HYPGEN_API hypgen_status hypgen_cancel(hypgen_planner* planner);

/* Plays a step that counts nowhere, so that the first plan of an episode takes no longer than later ones: plans
 * for so many seconds (0: the settings' time), acts in a simulated world, and updates the belief. It gives the
 * plan's status. The call needs no hypgen_reset before it, and needs one after it. */
HYPGEN_API hypgen_status hypgen_warm_up(hypgen_planner* planner, double seconds, char** error);

/* Takes in the action that was done and the key of what was seen after it. */
HYPGEN_API hypgen_status hypgen_update(hypgen_planner* planner, int32_t action, const uint64_t* key,
                                       size_t words, char** error);
/* The same with the values of all that is seen. */
HYPGEN_API hypgen_status hypgen_update_values(hypgen_planner* planner, int32_t action, const int32_t* seen,
                                              size_t count, char** error);
/* The same with a JSON object by name. */
HYPGEN_API hypgen_status hypgen_update_named(hypgen_planner* planner, int32_t action, const char* seen,
                                             char** error);

/* The key of values, or of a JSON object by name, and back. `words` is the description's "key_words". */
HYPGEN_API hypgen_status hypgen_encode(hypgen_planner* planner, const int32_t* seen, size_t count,
                                       uint64_t* key, size_t words, char** error);
HYPGEN_API hypgen_status hypgen_encode_named(hypgen_planner* planner, const char* seen, uint64_t* key,
                                             size_t words, char** error);
HYPGEN_API hypgen_status hypgen_decode(hypgen_planner* planner, const uint64_t* key, size_t words,
                                       char** seen, char** error);

/* Actions by name. The name that is given back is a view, valid until the planner is destroyed. */
HYPGEN_API hypgen_status hypgen_find_action(hypgen_planner* planner, const char* name, int32_t* action,
                                            char** error);
HYPGEN_API hypgen_status hypgen_action_name(hypgen_planner* planner, int32_t action, const char** name,
                                            char** error);

/* The tree that the last plan decided by, as a JSON object: `depth` levels of actions, and the `top` actions of each
 * node that trials took most, and the `top` groups of each action that most scenarios are in. It has `nodes` beliefs
 * and actions at most: what is below those beliefs that most trials entered. Bounds are those of what the node itself
 * is worth. Where "pruning" is above 0 they are less that for each node below, divided by the node's discount and its
 * share of all scenarios. At most 100 levels. */
HYPGEN_API hypgen_status hypgen_tree(hypgen_planner* planner, int32_t depth, int32_t top, int32_t nodes,
                                     char** json, char** error);

/* The belief in all hidden variables: a JSON array of objects with "variable" and either "values" and their
 * probabilities, or "mean" and "deviation" of a float. */
HYPGEN_API hypgen_status hypgen_belief(hypgen_planner* planner, char** json, char** error);
/* Draws `count` states from the belief into `values`, one after the other. Each has as many values as the
 * description's "variables" says; a hidden variable's begin at its "first". `size` is the length of `values`. */
HYPGEN_API hypgen_status hypgen_sample_belief(hypgen_planner* planner, uint64_t seed, size_t count,
                                              int32_t* values, size_t size, char** error);
/* The probability that a hidden variable, such as "rock.good[3]", has a value, such as "true". */
HYPGEN_API hypgen_status hypgen_probability(hypgen_planner* planner, const char* variable, const char* value,
                                            double* probability, char** error);

/* Simulated worlds: many of one model beside each other, moved by one call. Episode e of a seed draws what the
 * model's solver draws in run e of that seed. World i of n plays the episodes i, i + n, i + 2 n and so on.
 *
 * - Worlds take one call at a time: a second thread's call is refused with HYPGEN_BUSY. They have no threads of
 *   their own, so that several of them may be stepped by as many threads.
 * - The caller has the arrays that calls read and write. Only hypgen_worlds_create and
 *   hypgen_worlds_start allocate.
 * - `count` is the number of worlds, as a check of the arrays' length.
 * - On a GPU their states stay there. HYPGEN_NO_GPU of a call means that the GPU has failed: destroy the worlds. A
 *   fork leaves them to the parent. */

typedef struct hypgen_worlds hypgen_worlds;

typedef struct hypgen_worlds_options {
  size_t size;        /* sizeof(hypgen_worlds_options) */
  size_t count;       /* of worlds: 1 to 2^24 */
  uint64_t seed;      /* of all random numbers */
  const char* params; /* as in hypgen_options; NULL: the model's own values */
  /* Where the worlds are: cpu, cuda (the first GPU) or cuda:N. NULL: the CPU. Results are the same on each. */
  const char* device;
} hypgen_worlds_options;

#define HYPGEN_NEXT_EPISODE INT32_MIN /* in place of an action */

/* Where a step writes: an entry or a row for each world. NULL: not wanted. */
typedef struct hypgen_worlds_results {
  size_t size;       /* sizeof(hypgen_worlds_results) */
  double* rewards;   /* NaN where the model's reward is no number */
  int32_t* seen;     /* rows of what was seen; where nothing was, the least value of each, and 0 of floats */
  uint64_t* keys;    /* rows of the words of its key; zeroes where nothing was seen */
  int32_t* visible;  /* rows of the visible variables after the step */
  uint8_t* legal;    /* rows of all actions: 1 where it is allowed next; zeroes once the episode has ended */
  uint8_t* terminal; /* 1 where the step has ended the episode */
  uint8_t* success;  /* 1 where the model's `success when` held */
} hypgen_worlds_results;

/* Makes worlds without episodes. */
HYPGEN_API hypgen_status hypgen_worlds_create(const hypgen_model* model, const hypgen_worlds_options* options,
                                              hypgen_worlds** worlds, char** error);
/* Does nothing where `worlds` is NULL, busy or destroyed; the last is HYPGEN_WRONG_ARGUMENT. */
HYPGEN_API hypgen_status hypgen_worlds_destroy(hypgen_worlds* worlds);

/* Ends all episodes. Later ones draw by this seed, and are numbered afresh. */
HYPGEN_API hypgen_status hypgen_worlds_seed(hypgen_worlds* worlds, uint64_t seed, char** error);

/* Episodes that begin later start with the values of a JSON object: visible and hidden variables by name, such as
 * {"rock.good": [true, ..]}, or single entries, {"rock.good[3]": true}. What it leaves out is drawn, and what
 * depends on given values follows from these. NULL: as the model says. */
HYPGEN_API hypgen_status hypgen_worlds_start(hypgen_worlds* worlds, const char* start, char** error);

/* Starts an episode in each world whose entry of `mask` is not 0; NULL: in all. `episodes` has the number for each
 * world, below 2^32, from which its next ones count on; NULL: its next one. */
HYPGEN_API hypgen_status hypgen_worlds_reset(hypgen_worlds* worlds, const uint8_t* mask,
                                             const uint64_t* episodes, size_t count, char** error);

/* Rows of the visible variables, and of all actions: 1 where it is allowed. */
HYPGEN_API hypgen_status hypgen_worlds_visible(hypgen_worlds* worlds, int32_t* visible, size_t count,
                                               char** error);
HYPGEN_API hypgen_status hypgen_worlds_legal(hypgen_worlds* worlds, uint8_t* legal, size_t count,
                                             char** error);

/* Does an action in each world. HYPGEN_NEXT_EPISODE starts its next episode instead, with a reward of 0. If a world
 * cannot do its action, or has no episode under way, none of them moves. HYPGEN_MODEL_NAN: all have moved, and
 * a reward is NaN. */
HYPGEN_API hypgen_status hypgen_worlds_step(hypgen_worlds* worlds, const int32_t* actions, size_t count,
                                            const hypgen_worlds_results* out, char** error);

#ifdef __cplusplus
}
#endif

#endif /* HYPGEN_H */
