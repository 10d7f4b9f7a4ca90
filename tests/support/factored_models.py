# SPDX-License-Identifier: Apache-2.0
"""Small models whose hidden variables are independent, of every form that the rules allow."""

from __future__ import annotations

from hypgen.dsl import ir
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.parse import parse

HEAD = "model Trial\ndiscount 0.9\naction act: 0 .. 3\nreward none = 0\npolicy default = 1\n"

# Models whose hidden variables are independent; each is checked against Bayes' rule by enumeration.
FACTORED = {
    # RockSample's dynamics: a family of flags, of which the action chooses one to look at.
    "flags": """
      type Rock = 1 .. 4
      enum Look { nothing, fine, bad }
      element rover { visible x: 0 .. 3  init x = 0  x' = clamp(x + (if act == 3 then 1 else 0)) }
      element rock[r in Rock] {
        hidden good: bool
        init good ~ bernoulli(0.2 * r)
        good' = good and not (act == 2 and rover.x == 1 and r == 2)
      }
      fn target(): Rock = rover.x + 1
      observe look: Look ~
        if act != 0 then nothing
        else if rock[target()].good' then { fine: 0.8, else bad } else { bad: 0.7, else fine }""",
    # Two elements of different kinds: correlated variables inside, a let without a draw, a fixed one; a
    # visible variable tells of one and an observation of the other.
    "mixed": """
      type Low = 2 .. 3   type Level = 2 .. 5   type Grade = 0 .. 2   type Place = 0 .. 4
      element tank {
        hidden level: 2 .. 5   hidden leaks: bool   hidden fixed grade: 0 .. 2
        init grade ~ uniform(Grade)
        init leaks ~ bernoulli(0.1 + 0.2 * grade)
        init level ~ if leaks then uniform(Low) else uniform(Level)
        let inflow = if act == 1 then 1 else 0
        level' ~ { clamp(level + inflow - (if leaks' then 1 else 0)): 0.7, else level }
        leaks' ~ bernoulli(if leaks then 0.9 else 0.05 * grade)
        observe gauge: 2 .. 5 ~ noisy(level', if act == 2 then 0.9 else 0.5)
      }
      element target {
        hidden at: Place
        init at ~ uniform(Place)
        at' ~ uniform(p in Place where abs(p - at) <= 1: p)
      }
      element robot {
        visible near: bool  visible count: 0 .. 7
        init near = false   init count = 0
        near' ~ noisy(target.at' <= act, 0.75)
        count' = if near then clamp(count + 1) else count
      }
      terminal when robot.count == 7 or (act == 3 and target.at' == 4)""",
    # What is seen at the start: of each member its own, of one that a visible variable chooses, and an array
    # with an entry for each. Inits of hidden variables read what is seen, too.
    "first_looks": """
      type Bot = 1 .. 2   type Spot = 0 .. 3   type Kind = 0 .. 1
      element mast { visible fixed turned: Bot  init turned ~ uniform(Bot) }
      element bot[b in Bot] {
        hidden fixed kind: Kind   hidden at: Spot   hidden fixed keen: bool
        init kind ~ uniform(Kind)
        init at ~ uniform(p in Spot where p >= kind: p)
        init keen ~ bernoulli(if lit then 0.8 else 0.3)
        at' ~ if keen then uniform(p in Spot where abs(p - at) <= kind: p) else at
        observe lit: bool at start ~ bernoulli(0.2 * at + 0.1 * kind)
      }
      element tower {
        observe far: Spot at start ~ noisy(bot[mast.turned].at, 0.6)
        observe high: bool[Bot] at start ~ [b in Bot: noisy(bot[b].at > 1, 0.7)]
      }
      observe seen: Spot ~ if act == 0 then noisy(bot[2].at', 0.8) else 0""",
    # The episode's end tells of every member; each member has a sensor of its own.
    "crowd": """
      type Ped = 0 .. 2
      element car { visible s: 0 .. 9  init s = 0  s' ~ { clamp(s + 1): 0.8, else s } }
      element ped[i in Ped] {
        hidden place: 0 .. 3   hidden fixed goal: bool
        init goal ~ bernoulli(0.5)
        init place = if goal then 0 else i
        place' ~ if goal then { clamp(place + 1): 0.6, else place } else { clamp(place - 1): 0.6, else place }
        observe seen: 0 .. 3 ~ noisy(place', 0.8)
      }
      fn hit(i: Ped): bool = car.s == 5 and ped[i].place == 3
      terminal when car.s' == 9 or any(i in Ped: hit(i)')""",
}


def model_of(text: str) -> ir.Model:
    """Return the checked model of the text after ``HEAD``."""
    source = Source("trial.pomdp", HEAD + text)
    file = parse(source)
    assert isinstance(file, ast.ModelFile)
    return lower(file, {}, source)
