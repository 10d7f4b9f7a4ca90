# SPDX-License-Identifier: Apache-2.0
"""Many models in one program, which writes the trace of any of them: compiling one by one takes too long."""

from __future__ import annotations

import re
import subprocess
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from hypgen.codegen.generate import generate
from hypgen.dsl import ir
from hypgen.dsl.interpret.trace import trace
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.parse import parse
from hypgen.runtime.builder.compile_flags import host_flags, lane_flags
from hypgen.runtime.builder.tools import find_compiler, widest_lanes
from support import traces
from support.paths import ROOT

INCLUDE = ROOT / "runtime" / "include"
OUTPUT = ROOT / "runtime" / "src" / "core" / "output.cpp"  # traces are written by it
# Most of a compiler's time goes into optimising; what is compared does not depend on it.
FLAGS = ("-std=c++17", "-O1", *host_flags(), "-w")
SEED = 20261122
LANES = 20  # walks with steps that warps share

MAIN = """#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <hypgen/lanes/choice.hpp>
#include <hypgen/leaves/rollout.hpp>
#include <hypgen/model/descriptor.hpp>
#include <hypgen/verify/schedule.hpp>
#include <hypgen/verify/trace.hpp>

{includes}

namespace hypgen_lanes {{
{kernels}
}}

namespace {{

// Whether warps that share the steps of some walks, in any order, come to the same as plain steps.
template <class M>
bool schedule_holds(const typename M::Params& params, std::string& error) {{
  constexpr std::uint32_t kLanes = {lanes};
  const hypgen::DigestRange range{{{{{seed}, 0}}, 0, kLanes, 5}};
  std::uint64_t plain[kLanes], shared[kLanes];
  hypgen::walk_lanes<M>(params, range, 1, plain);
  for (const int warps : {{2, 3, 4, 8, 16}}) {{
    const hypgen::ScheduleFault fault = hypgen::walk_lanes<M>(params, range, warps, shared);
    const bool equal = std::equal(plain, plain + kLanes, shared);
    if (equal && fault.kind == hypgen::ScheduleFault::Kind::kNone) continue;
    error = "the schedule of " + std::to_string(warps) + " warps differs";
    return false;
  }}
  return true;
}}

// Whether rollouts in lanes earn what the same rollouts earn one by one, over several batches of lanes.
template <class M>
bool lanes_hold(const typename M::Params& params, const hypgen_lanes::Kernel& kernel, std::string& error) {{
  constexpr std::uint32_t kScenarios = 100;
  constexpr int kDepth = 12;
  if (!hypgen::has_lanes(kernel)) return true;
  std::vector<typename M::Fixed> fixed(kScenarios);
  hypgen::EvaluatorOptions options;
  options.max_depth = kDepth;
  hypgen::SearchSetup setup;
  setup.key = {{{seed}, 1}};
  setup.depth_limit = kDepth;
  std::vector<hypgen::ScenarioBounds> found[2];
  for (const bool wide : {{false, true}}) {{
    options.lanes = wide ? &kernel : nullptr;
    options.measures_lanes = false;
    hypgen::DrawCache cache(kScenarios, 1);
    hypgen::StepClock clock;
    hypgen::Rollout<M> rollout(params, cache, clock, options);
    cache.begin_search(setup.key, 0);
    clock.begin_search(setup.deadline);
    rollout.begin_search(setup);
    std::vector<typename M::History> histories(kScenarios);
    for (std::uint32_t i = 0; i < kScenarios; ++i) {{
      typename M::State state;
      hypgen::PhiloxDraws draws(setup.key, i, 0);
      M::init_visible(params, draws, fixed[i], state);
      M::init_hidden(params, draws, fixed[i], state);
      if constexpr (M::kHasHistory) M::init_history(params, fixed[i], state, histories[i]);
      found[wide].push_back(wide ? rollout.begin(fixed[i], i, state, histories[i], i)
                                 : rollout.bounds(fixed[i], state, histories[i], i, 0));
    }}
    if (!wide) continue;
    rollout.play(fixed.data(), 0);
    for (hypgen::ScenarioBounds& bounds : found[wide]) bounds.lower = rollout.end(bounds);
  }}
  for (std::uint32_t i = 0; i < kScenarios; ++i) {{
    if (found[0][i].lower == found[1][i].lower) continue;
    error = std::string("rollout ") + std::to_string(i) + " differs in lanes, " + kernel.name;
    return false;
  }}
  return true;
}}

template <class M>
int run(const hypgen::ParamValues& values, const hypgen::TraceOptions& options,
        const std::vector<const hypgen_lanes::Kernel*>& kernels) {{
  static typename M::Params params{{}};
  std::string error;
  if (M::load(values, params, error) && hypgen::Tracer<M>(params, options).write(error) &&
      schedule_holds<M>(params, error)) {{
    const auto holds = [&](const auto* kernel) {{ return lanes_hold<M>(params, *kernel, error); }};
    if (std::all_of(kernels.begin(), kernels.end(), holds)) return 0;
  }}
  std::fprintf(stderr, "%s\\n", error.c_str());
  return 1;
}}

}}  // namespace

int main(int, char** argv) {{
  hypgen::TraceOptions options;
  options.file = argv[2];
  options.seed = {seed};
  options.scenarios = static_cast<std::uint32_t>(std::atoi(argv[3]));
  options.steps = static_cast<std::uint32_t>(std::atoi(argv[4]));
  hypgen::ParamValues values;
  switch (std::atoi(argv[1])) {{
{cases}
  }}
  return 2;
}}
"""


@dataclass(frozen=True)
class Size:
    """How much of each model is compared."""

    scenarios: int = 300
    steps: int = 5


def compare(texts: Sequence[str], folder: Path, size: Size) -> list[str | None]:
    """Return for each model what is wrong with it, None where C++ and the interpreter agree.

    A text that the checker refuses is reported as ``refused: CODE`` with the message.
    """
    results = {i: lowered(text, i) for i, text in enumerate(texts)}
    models = {i: result for i, result in results.items() if not isinstance(result, str)}
    # Only a model without a lower bound rolls out, in lanes too.
    models = {i: replace(model, lower=None) if i % 3 else model for i, model in models.items()}
    found = compare_models(models, folder, lambda model: size)
    return [found[i] if i in found else str(result) for i, result in results.items()]


def compare_models(
    models: Mapping[int, ir.Model], folder: Path, size_of: Callable[[ir.Model], Size]
) -> dict[int, str | None]:
    """Return for each model what is wrong with it, None where C++ and the interpreter agree.

    Each must be called ``Batch<number>``, as ``numbered`` makes it.
    """
    found: dict[int, str | None] = {}
    headers: dict[int, str] = {}
    lanes: dict[int, str] = {}
    for i, model in models.items():
        try:
            files = generate(model)
            headers[i] = files[f"src/batch{i}.hpp"]
            if "src/lanes.cpp" in files:
                lanes[i] = files["src/lanes.cpp"]
        except Exception:
            found[i] = f"code generation failed:\n{traceback.format_exc(limit=-3)}"
    models = {i: models[i] for i in headers}
    if not models:
        return found
    program = folder / "batch"
    problem = _build(program, models, headers, lanes)
    for i, model in models.items():
        if problem is None:
            found[i] = _difference(program, i, model, size_of(model))
        else:  # some model does not compile: which?
            found[i] = problem if len(models) == 1 else compare_models({i: model}, folder, size_of)[i]
    return found


def numbered(model: ir.Model, number: int) -> ir.Model:
    """Return the model as ``Batch<number>``."""
    return replace(model, name=f"Batch{number}")


def lowered(text: str, number: int) -> ir.Model | str:
    """Return the model as ``Batch<number>``, or why there is none."""
    source = Source(f"batch_{number}.pomdp", re.sub(r"^model \w+", f"model Batch{number}", text))
    try:
        return lower(parse(source), {}, source)
    except ModelError as error:
        return f"refused: {error.diagnostics[0].code}: {error.diagnostics[0].message}"
    except Exception:
        return f"the checker failed:\n{traceback.format_exc(limit=-3)}"


def _build(
    program: Path, models: Mapping[int, ir.Model], headers: Mapping[int, str], lanes: Mapping[int, str]
) -> str | None:
    for i in models:
        (program.parent / f"batch{i}.hpp").write_text(headers[i])
    compiler = find_compiler()
    kinds = {k: flags for k, flags in lane_flags().items() if widest_lanes(compiler)}
    objects = []
    for kind, flags in kinds.items():
        unit = program.with_name(f"lanes_{kind}.cpp")
        unit.write_text("\n".join(lanes.values()))
        objects.append(str(unit.with_suffix(".o")))
        command = [str(compiler.path), *FLAGS, *flags, f"-I{INCLUDE}", "-c", str(unit), "-o", objects[-1]]
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode != 0:
            return f"the C++ compiler failed on lanes:\n{run.stderr[:3000]}"
    kernels = [f"kernel_Batch{i}_{kind}" for i in lanes for kind in kinds]
    cases = [
        f"    case {i}:\n"
        + "".join(f'      values.set("{p.name}", {{{_numbers(p)}}});\n' for p in model.params)
        + f"      return run<hypgen::models::Batch{i}>(values, options, {{"
        + ", ".join(f"&hypgen_lanes::kernel_Batch{i}_{kind}" for kind in (kinds if i in lanes else ()))
        + "});"
        for i, model in models.items()
    ]
    includes = "\n".join(f'#include "batch{i}.hpp"' for i in models)
    main = program.with_suffix(".cpp")
    declared = "\n".join(f"extern const Kernel {kernel};" for kernel in kernels)
    main.write_text(
        MAIN.format(includes=includes, kernels=declared, cases="\n".join(cases), seed=SEED, lanes=LANES)
    )
    command = [
        str(compiler.path),
        *FLAGS,
        f"-I{INCLUDE}",
        str(main),
        *objects,
        str(OUTPUT),
        "-o",
        str(program),
    ]
    run = subprocess.run(command, capture_output=True, text=True)
    return None if run.returncode == 0 else f"the C++ compiler failed:\n{run.stderr[:3000]}"


def _numbers(param: ir.Param) -> str:
    assert param.default is not None
    return ", ".join(repr(float(x)) for x in param.default)


def _difference(program: Path, number: int, model: ir.Model, size: Size) -> str | None:
    path = program.parent / "trace"
    command = [str(program), str(number), str(path), str(size.scenarios), str(size.steps)]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode != 0:
        return f"the program ended with {run.returncode}: {run.stderr[:1000]}"
    actual = traces.read(path, model)
    path.unlink()
    try:
        expected = trace(model, SEED, size.scenarios, size.steps)
    except Exception:
        return f"the interpreter failed:\n{traceback.format_exc(limit=-3)}"
    return traces.difference(expected, actual, model, size.scenarios)
