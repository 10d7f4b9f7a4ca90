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
from hypgen.runtime.builder.compile_flags import host_flags
from hypgen.runtime.builder.tools import find_compiler
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

#include <hypgen/model/descriptor.hpp>
#include <hypgen/verify/schedule.hpp>
#include <hypgen/verify/trace.hpp>

{includes}

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

template <class M>
int run(const hypgen::ParamValues& values, const hypgen::TraceOptions& options) {{
  static typename M::Params params{{}};
  std::string error;
  if (M::load(values, params, error) && hypgen::Tracer<M>(params, options).write(error) &&
      schedule_holds<M>(params, error)) {{
    return 0;
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
    for i, model in models.items():
        try:
            headers[i] = generate(model)[f"src/batch{i}.hpp"]
        except Exception:
            found[i] = f"code generation failed:\n{traceback.format_exc(limit=-3)}"
    models = {i: models[i] for i in headers}
    if not models:
        return found
    program = folder / "batch"
    problem = _build(program, models, headers)
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


def _build(program: Path, models: Mapping[int, ir.Model], headers: Mapping[int, str]) -> str | None:
    for i in models:
        (program.parent / f"batch{i}.hpp").write_text(headers[i])
    cases = [
        f"    case {i}:\n"
        + "".join(f'      values.set("{p.name}", {{{_numbers(p)}}});\n' for p in model.params)
        + f"      return run<hypgen::models::Batch{i}>(values, options);"
        for i, model in models.items()
    ]
    includes = "\n".join(f'#include "batch{i}.hpp"' for i in models)
    main = program.with_suffix(".cpp")
    main.write_text(MAIN.format(includes=includes, cases="\n".join(cases), seed=SEED, lanes=LANES))
    command = [str(find_compiler().path), *FLAGS, f"-I{INCLUDE}", str(main), str(OUTPUT), "-o", str(program)]
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
