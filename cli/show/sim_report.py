# SPDX-License-Identifier: Apache-2.0
"""The report of ``hypgen sim``: in words, or as JSON lines."""

from __future__ import annotations

import json
import math
import textwrap
from typing import TYPE_CHECKING, Any, Protocol

import click

from hypgen.cli.output import say
from hypgen.cli.show.episode_drawing import EpisodeDrawing
from hypgen.dsl import ir
from hypgen.dsl.interpret.value_text import (
    action_text,
    actions_with,
    array_text,
    entry_names,
    factor_texts,
    value_text,
)
from hypgen.dsl.types import Bool, Float, Int, Type

if TYPE_CHECKING:
    from hypgen.dsl.interpret.episode import Episode, Outcome, Values

_WIDTH = 100
_ACTIONS = 20  # as many as are listed unasked
_LISTED = 4  # entries of an observation that have a line each; values of a belief


class Report(Protocol):
    """What is told of an episode, as it happens."""

    def start(self, seed: int, number: int) -> None:
        """Tell what is played and how it starts."""
        ...

    def step(self, before: Values, outcome: Outcome) -> None:
        """Tell a step; ``before`` are the values before it."""
        ...

    def undone(self) -> None:
        """Tell that the last step was taken back."""
        ...

    def state(self) -> None:
        """Tell the whole state."""
        ...

    def legal(self, which: str = "") -> None:
        """Tell the legal actions: the first ones, "all", or those with some words in their names."""
        ...

    def belief(self) -> None:
        """Tell what the agent believes of hidden variables, and what the policy remembers."""
        ...

    def note(self, text: str) -> None:
        """Tell the user something that is not part of the episode."""
        ...

    def end(self) -> None:
        """Tell how the episode went."""
        ...


class TextReport:
    """For people: values by name, after the first step only those that changed."""

    def __init__(self, episode: Episode, show_hidden: bool, *, draws: bool = False) -> None:
        self._episode = episode
        self._model = episode.model
        self._variables = [v for v in self._model.variables if v.visible or show_hidden]
        self._drawing = EpisodeDrawing(episode, show_hidden) if draws else None

    def start(self, seed: int, number: int) -> None:
        """Print the model's name, the state and the legal actions."""
        click.echo(f"{self._model.name}: episode {number} of seed {seed}")
        self.state()
        for v in self._model.variables:
            if v.informative:
                self._observed(v.name, v.element, v.type, v.indices, self._episode.values()[v.name])
        self._draw()
        self.legal()

    def step(self, before: Values, outcome: Outcome) -> None:
        """Print the action, what changed, what was observed and earned."""
        model, now = self._model, self._episode.now
        click.echo(f"step {now.time - 1}: {action_text(outcome.action, model.action)}")
        after = self._episode.values()
        for v in self._variables:
            names = entry_names(v.name, v.element, v.indices, model)
            for name, old, new in zip(names, before[v.name], after[v.name], strict=True):
                if old != new and (old == old or new == new):  # not from NaN to NaN
                    click.echo(f"  {name}: {value_text(old, v.type)} -> {value_text(new, v.type)}{_mark(v)}")
        for o in model.observations if outcome.observation else ():
            indices = tuple(b.type for b in o.binders)
            self._observed(o.name, o.element, o.type, indices, outcome.observation[o.name])
        earned = [f"{name} {value:.6g}" for name, value in outcome.terms.items() if value]
        terms = f" ({', '.join(earned)})" if len(outcome.terms) > 1 and earned else ""
        click.echo(
            f"  reward {outcome.reward:.6g}{terms}, so far {now.earned:.6g}, discounted {now.discounted:.6g}"
        )
        if outcome.error:
            click.echo("  a reward term is not a number: it counts as 0")
        self._draw()

    def _draw(self) -> None:
        for line in self._drawing.lines() if self._drawing is not None else ():
            click.echo(line)

    def _observed(
        self, name: str, element: str | None, type_: Type, indices: tuple[Type, ...], values: list[Any]
    ) -> None:
        if len(values) > _LISTED:
            click.echo(_wrapped(f"observed {name} = {array_text(values, type_, indices)}"))
            return
        for entry, value in zip(entry_names(name, element, indices, self._model), values, strict=True):
            click.echo(f"  observed {entry} = {value_text(value, type_)}")

    def undone(self) -> None:
        """Print where the episode stands again."""
        click.echo(f"back before step {self._episode.now.time}")
        self._draw()

    def state(self) -> None:
        """Print every variable."""
        values = self._episode.values()
        for v in self._variables:
            line = f"{v.name} = {array_text(values[v.name], v.type, v.indices)}{_mark(v)}"
            click.echo(_wrapped(line))

    def legal(self, which: str = "") -> None:
        """Print the legal actions' names, or some of them."""
        legal, action = self._episode.legal(), self._model.action
        head, tail = f"{len(legal)} of {action.count} actions are legal: ", ""
        if which not in ("", "all"):
            chosen = set(actions_with(which, action))
            head = f"{len(chosen.intersection(legal))} of {len(legal)} legal actions have '{which}': "
            legal = [code for code in legal if code in chosen]
        elif not which and len(legal) > _ACTIONS:
            tail = f" and {len(legal) - _ACTIONS} more; "
            tail += "`legal all` prints all, `legal WORDS` those with the words"
            legal = legal[:_ACTIONS]
        names = ", ".join(action_text(code, action) for code in legal)
        click.echo(_wrapped(f"{head}{names or 'none'}{tail}"))

    def belief(self) -> None:
        """Print each exact factor's likeliest values, the floats that the policy knows, and its memory."""
        believed, remembered, model = self._episode.belief(), self._episode.memory(), self._model
        for factor in model.factors:
            members = zip(factor_texts(factor, model), believed.get(factor.element, ()), strict=False)
            for (label, texts), chances in members:
                ranked = sorted(zip(chances, texts, strict=True), key=lambda pair: -pair[0])
                likely = [f"{text} {chance:.3g}" for chance, text in ranked if chance > 0]
                rest = f"; {len(likely) - _LISTED} more" if len(likely) > _LISTED else ""
                click.echo(_wrapped(f"believed {label}: {'; '.join(likely[:_LISTED])}{rest}"))
        moments = self._episode.moments()
        for factor in (f for f in model.factors if f.element in moments):
            for (label, _), known in zip(factor_texts(factor, model), moments[factor.element], strict=True):
                mean, deviation = known
                click.echo(_wrapped(f"believed {label}: mean {mean:.6g}, deviation {deviation:.3g}"))
        sampled = [f for f in model.factors if not (f.exact or f.joined or f.element in moments)]
        for name in [f.element for f in sampled] + [o.element for o in model.obstacles]:
            click.echo(f"  {name}: kept as particles, which only a solver has")
        for r in model.history.registers:
            click.echo(_wrapped(f"remembered {r.name} = {array_text(remembered[r.name], r.type, r.indices)}"))

    def note(self, text: str) -> None:
        """Print a text."""
        click.echo(text)

    def end(self) -> None:
        """Print how the episode ended and what it earned."""
        now = self._episode.now
        how = "ended" if now.terminal else "stopped"
        success = "" if self._model.success is None else ", a success" if now.success else ", no success"
        click.echo(
            f"{how} after {now.time} step{'' if now.time == 1 else 's'}{success}: "
            f"return {now.earned:.6g}, discounted {now.discounted:.6g}"
        )


class JsonReport:
    """For programs: an object a line, its ``type`` says which."""

    def __init__(self, episode: Episode, show_hidden: bool) -> None:
        self._episode = episode
        self._model = episode.model
        self._variables = [v for v in self._model.variables if v.visible or show_hidden]

    def start(self, seed: int, number: int) -> None:
        """Print the state that the episode starts in."""
        values, first = self._episode.values(), [v for v in self._model.variables if v.informative]
        seen = {v.name: _data(values[v.name], v.type, bool(v.indices)) for v in first}
        self._print(
            "start",
            model=self._model.name,
            seed=seed,
            episode=number,
            **({"observation": seen} if first else {}),
            state=self._state(),
        )

    def step(self, before: Values, outcome: Outcome) -> None:
        """Print a step and the state after it."""
        now, model = self._episode.now, self._model
        seen = {
            o.name: _data(outcome.observation[o.name], o.type, bool(o.binders))
            for o in (model.observations if outcome.observation else ())
        }
        self._print(
            "step",
            step=now.time - 1,
            action=outcome.action,
            action_name=action_text(outcome.action, model.action),
            observation=None if now.terminal else seen,
            reward=outcome.reward,
            rewards=outcome.terms,
            discounted_return=now.discounted,
            terminal=now.terminal,
            success=None if model.success is None else now.success,
            state=self._state(),
        )

    def undone(self) -> None:
        """Print the state again."""
        self._print("undo", step=self._episode.now.time, state=self._state())

    def state(self) -> None:
        """Print the state."""
        self._print("state", step=self._episode.now.time, state=self._state())

    def legal(self, which: str = "") -> None:
        """Print the legal actions' names, or some of them."""
        chosen = None if which in ("", "all") else set(actions_with(which, self._model.action))
        codes = [code for code in self._episode.legal() if chosen is None or code in chosen]
        names = [action_text(code, self._model.action) for code in codes]
        self._print("legal", step=self._episode.now.time, actions=names)

    def belief(self) -> None:
        """Print the probabilities of each exact factor's values, what the policy knows of floats, and its
        memory.
        """
        memory = {
            r.name: _data(self._episode.memory()[r.name], r.type, bool(r.indices))
            for r in self._model.history.registers
        }
        known = {"factors": self._episode.belief(), "moments": self._episode.moments()}
        self._print("belief", step=self._episode.now.time, **known, memory=memory)

    def note(self, text: str) -> None:
        """Print a text to standard error."""
        say(text)

    def end(self) -> None:
        """Print what the episode earned."""
        now = self._episode.now
        self._print(
            "end",
            steps=now.time,
            discounted_return=now.discounted,
            **{"return": now.earned},
            terminal=now.terminal,
            success=None if self._model.success is None else now.success,
        )

    def _state(self) -> dict[str, Any]:
        values = self._episode.values()
        return {v.name: _data(values[v.name], v.type, bool(v.indices)) for v in self._variables}

    @staticmethod
    def _print(kind: str, **fields: Any) -> None:
        click.echo(json.dumps({"type": kind, **fields}))


def _data(values: list[Any], t: Type, is_array: bool) -> Any:
    """Return an array's entries, row-major, or a scalar's value; enums and records by name."""
    data = values if isinstance(t, Bool | Int) else [_datum(value, t) for value in values]
    return data if is_array else data[0]


def _datum(value: Any, t: Type) -> Any:
    """Return a float (null where it is not finite) or a name."""
    if isinstance(t, Float):
        return value if math.isfinite(value) else None
    return value_text(value, t)


def _mark(variable: ir.Variable) -> str:
    return "" if variable.visible else "  (hidden)"


def _wrapped(text: str) -> str:
    """Return the text indented, its long lines broken."""
    lines = []
    for line in text.split("\n"):
        start = "  " + line[: len(line) - len(line.lstrip())]
        filled = textwrap.fill(
            line.lstrip(),
            _WIDTH,
            initial_indent=start,
            subsequent_indent=f"{start}  ",
            break_long_words=False,
            break_on_hyphens=False,
        )
        lines.append(filled)
    return "\n".join(lines)
