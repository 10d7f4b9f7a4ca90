# SPDX-License-Identifier: Apache-2.0
"""What is generated for each model compiles, and the compiler warns of nothing."""

from __future__ import annotations

import dataclasses
import subprocess
from pathlib import Path

import pytest
from support import ir_samples
from support.ir_samples import const, equal
from support.paths import EXAMPLES, ROOT

from hypgen.codegen.generate import generate
from hypgen.codegen.layout.naming import Names
from hypgen.dsl import ir
from hypgen.dsl.load import load
from hypgen.dsl.types import BOOL, Enum, Float, Int, Variant
from hypgen.runtime.builder.compile_flags import host_flags
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.tools import find_compiler

pytestmark = pytest.mark.cxx
MODELS = sorted(EXAMPLES.glob("*.pomdp"))
SAMPLES = (ir_samples.tiger, ir_samples.rocks, ir_samples.wanderer)
FLAGS = ["-std=c++17", "-O1", "-c", "-Wall", "-Wextra", "-Wconversion", "-Werror", *host_flags()]


def hostile() -> ir.Model:
    """Build Tiger with names that C++ or the generated struct would like for themselves."""
    model = ir_samples.tiger()
    door = Enum("State", (Variant("int"), Variant("value")))
    act = Enum("Key", (Variant("class"), Variant("step"), Variant("is_step", Int(1, 2))))
    read = ir.StateRead(door, "new.delete")
    line = ir_samples.span(3)
    function = ir.Function(
        "filter",
        (ir.Binder("params", Int(0, 3)), ir.Binder("std", BOOL)),
        Int(0, 3),
        ir.If(Int(0, 3), ir.Local(BOOL, "std"), ir.Local(Int(0, 3), "params"), const(0)),
        line,
    )
    return dataclasses.replace(
        model,
        name="hypgen",
        enums=(door, act),
        params=(ir.Param("double", Float(), (), (0.5,), line),),
        elements=(ir.Element("new", None, line),),
        variables=(ir.Variable("new.delete", "new", door, (), False, False, line),),
        functions=(function,),
        action=ir.Action("state", act, (), line),
        inits=(ir.Assign("new.delete", (), ir.Uniform(door), ir.Site("init:new.delete"), line),),
        updates=(ir.Assign("new.delete", (), ir.Certain(door, read), ir.Site("new.delete"), line),),
        observations=(),
        rewards=(
            ir.Reward("for", None, None, ir.ParamRead(Float(), "double"), line),
            ir.Reward(
                "if",
                None,
                None,
                ir.Call(Int(0, 3), "filter", (const(3), equal(read, read))),
                line,
            ),
        ),
        legal=ir.IsVariant(BOOL, act, "class", ir.ActionRead(act)),
        policy=None,
        key=(),
    )


@pytest.fixture(scope="module")
def compiler() -> str:
    try:
        return str(find_compiler().path)
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")


@pytest.mark.parametrize(
    "model",
    [*(sample() for sample in SAMPLES), hostile(), *(load(path).model for path in MODELS)],
    ids=lambda m: m.name,
)
def test_the_compiler_has_nothing_to_say(model: ir.Model, compiler: str, tmp_path: Path) -> None:
    files = generate(model)
    header = next(Path(name) for name in files if name.endswith(".hpp"))
    (tmp_path / header.name).write_text(files[header.as_posix()])
    probe = tmp_path / "probe.cpp"
    probe.write_text(
        PROBE.replace("HEADER", header.name).replace("MODEL", f"hypgen::models::{Names(model).model}")
    )
    command = [
        compiler,
        *FLAGS,
        f"-I{ROOT / 'runtime' / 'include'}",
        str(probe),
        "-o",
        str(tmp_path / "probe.o"),
    ]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr


# Calls all that the runtime may call.
PROBE = """
#include "HEADER"
#include <hypgen/random/philox.hpp>

using M = MODEL;
using D = hypgen::PhiloxDraws;

int probe(const hypgen::ParamValues& values, std::string& error, std::int32_t* out) {
  M::Params params;
  M::Fixed fixed;
  M::State state, next;
  D draws({1, 2}, 3, 4);
  if (!M::load(values, params, error)) return -1;
  M::init_visible(params, draws, fixed, state);
  M::init_hidden(params, draws, fixed, state);
  M::export_visible(fixed, state, out);
  M::import_visible(out, fixed, state);
  M::export_state(fixed, state, out);
  M::History history, after;
  M::init_history(params, fixed, state, history);
  const int action = M::default_policy(params, fixed, state, history, draws);
  if (!M::is_legal(params, fixed, state, action)) return action;
  const hypgen::StepResult result = M::step(params, fixed, state, action, draws, next);
  const M::Key key = M::observe(params, fixed, state, action, draws, next);
  M::roll_history(params, fixed, state, action, draws, next, history, after);
  M::advance_history(params, fixed, state, action, key, next, after, history);
  const double weight = M::filter(params, fixed, state, action, key, draws, next);
  float bounds = M::lower(params, fixed, state, history) + M::upper(params, fixed, state);
  bounds += M::tail(params, fixed, state);
  return result.terminal && weight > static_cast<double>(bounds) ? M::kActionCount : M::kVisibleCount;
}
"""
