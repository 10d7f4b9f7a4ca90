# SPDX-License-Identifier: Apache-2.0
"""Values that are made of values: the code grows with their number, and does not take ages to generate."""

from pathlib import Path

import pytest

from hypgen.codegen.generate import generate
from hypgen.dsl.load import load

MODEL = """model Chain
action act: bool
discount 0.9
horizon 5
{top}
element e {{
  hidden v: {type}
  init v = {first}
{lets}
  v' = {value}
  observe o: bool ~ noisy(v' > {first}, 0.9)
}}
reward r = if e.v' > {first} then 1 else 0
"""


def local_lets(count: int) -> str:
    steps = "".join(f"let a{i + 1} = a{i} * a{i} + a{i} * 0.5 in " for i in range(count))
    value = f"let a0 = v in {steps} clamp(a{count}, 0.0, 1.0)"
    return MODEL.format(top="", type="float", first="0.5", lets="", value=value)


def local_ints(count: int) -> str:
    steps = "".join(
        f"let a{i + 1} = clamp(if a{i} > 3 then a{i} - 1 else a{i} + 1, 0, 9) in " for i in range(count)
    )
    return MODEL.format(top="", type="0 .. 9", first="5", lets="", value=f"let a0 = v in {steps} a{count}")


def element_lets(count: int) -> str:
    lets = "\n".join(f"  let a{i + 1} = a{i} * a{i} + a{i} * 0.5" for i in range(count))
    return MODEL.format(
        top="", type="float", first="0.5", lets=f"  let a0 = v\n{lets}", value=f"clamp(a{count}, 0.0, 1.0)"
    )


def functions(count: int) -> str:
    steps = "\n".join(f"fn f{i + 1}(x: float): float = f{i}(x) * f{i}(x + 1) + 0.5" for i in range(count))
    top = f"fn f0(x: float): float = x\n{steps}"
    return MODEL.format(top=top, type="float", first="0.5", lets="", value=f"clamp(f{count}(v), 0.0, 1.0)")


@pytest.mark.parametrize("chain", [local_lets, local_ints, element_lets, functions], ids=lambda f: f.__name__)
def test_code_is_linear_in_the_length_of_a_chain(chain, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    sizes = []
    for count in (10, 20, 30):  # a walk of each path would take 2^30 steps
        path = tmp_path / "chain.pomdp"
        path.write_text(chain(count))
        sizes.append(len(generate(load(path).model)["src/chain.hpp"]))
    assert sizes[2] - sizes[1] <= 1.3 * (sizes[1] - sizes[0])
