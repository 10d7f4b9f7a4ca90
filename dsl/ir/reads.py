# SPDX-License-Identifier: Apache-2.0
"""What evaluating an expression comes to: its own nodes, and those of the functions and lets it goes through.

Questions that need more than the nodes have walks of their own, and each says there what it asks.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from hypgen.dsl import ir
from hypgen.dsl.ir.walk import Node, children


def reached(
    nodes: Iterable[Node], functions: Mapping[str, ir.Function], lets: Mapping[str, ir.Let]
) -> Iterator[tuple[Node, bool]]:
    """Yield every node that evaluating ``nodes`` comes to, and whether it reads the next state for the state.

    A body comes before the arguments, each function and let once as it is and once primed. Functions and
    lets that the tables lack are not entered.
    """
    entered: set[tuple[type[Node], str, bool]] = set()
    pending = [(node, False) for node in nodes][::-1]
    while pending:
        node, primed = pending.pop()
        yield node, primed
        pending += [(child, primed) for child in children(node)][::-1]
        body: Node | None = None
        inner = primed
        match node:
            case ir.Call(function=name) if name in functions:
                body, inner = functions[name].body, primed or node.primed
            case ir.LetRead(let=name) if name in lets:
                body, inner = lets[name].dist, primed or node.primed
            case _:
                continue
        if (type(node), name, inner) not in entered:
            entered.add((type(node), name, inner))
            pending.append((body, inner))
