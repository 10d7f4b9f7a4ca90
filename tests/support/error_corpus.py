# SPDX-License-Identifier: Apache-2.0
"""Runs the corpus of wrong models as a user would, and writes what is said of them into it."""

from __future__ import annotations

import itertools
import json
import re
from pathlib import Path

import pytest

from hypgen.cli.show import belief_findings, bound_findings
from hypgen.cli.show.belief_findings import Asked
from hypgen.cli.show.error_index import Case, Entry, Example, entries
from hypgen.codegen.passes.enumerable import not_enumerable
from hypgen.dsl import ir, load
from hypgen.dsl.foreign import files, reader
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import Array, Frame
from hypgen.dsl.interpret.sampling.findings import Finding
from hypgen.dsl.interpret.sampling.sample_laws import check_densities, check_returns
from hypgen.dsl.interpret.sampling.sample_model import Walk
from hypgen.dsl.messages.diagnostic import Diagnostic, ModelError
from hypgen.dsl.messages.render import render_all
from hypgen.dsl.messages.source import Source
from hypgen.dsl.types import PROB
from hypgen.play.rank_statistics import Ranks
from support.paths import ROOT

FOLDER = ROOT / "cli" / "show" / "errors"
_SAYS = re.compile(r"(?ms)^says = ('''.*?'''|\"[^\n]*\")$")
FIFTH = ir.Const(PROB, 0.2)
SAMPLED = {"W04", "W09", "W10", *(code for code in entries() if code.startswith("C"))}


def draws_of_one_id() -> str:
    """Return an element with two draws whose names have the same number: a birthday in 32 bits."""
    seen: dict[int, str] = {}
    for number in itertools.count():
        site = ir.Site(f"let:draws.d{number}")
        other = seen.setdefault(site.id, site.path)
        if other != site.path:
            first, second = (path.partition(".")[2] for path in (other, site.path))
            return f"element draws {{ let {first} ~ bernoulli(0.5)  let {second} ~ bernoulli(0.5) }}\n"
    raise AssertionError


def prepare(entry: Entry, example: Example, folder: Path) -> None:
    """Write an example's files; what is too large for the index, or found by search, is made here."""
    text = example.source()
    if example is entry.wrong and entry.code == "E0140":
        text = text.replace("[1, 1]", f"[{'1, ' * 50_000}1]")
    if example is entry.wrong and entry.code == "E0807":
        text = draws_of_one_id().join(text.partition(entry.wrong.text)[::2])
    for name, other in example.files.items():
        (folder / name).parent.mkdir(exist_ok=True)
        if entry.code == "E0006":
            other = "# " + "x" * 16_000_000
        (folder / name).write_bytes(other.encode("latin-1"))
    (folder / "example.pomdp").write_text(text)


def imported(path: str) -> load.Loaded:
    content = files.read(path)
    if content is None:
        raise files.refusal(path)
    text = reader.import_text(path, content, None, None).text
    return load.load(path, given=Source("imported", text))


def loaded(example: Example) -> load.Loaded | load.LoadedLibrary:
    options = dict(zip(example.options[::2], example.options[1::2], strict=True))
    settings = [options["--set"]] if "--set" in options else []
    return load.load_any("example.pomdp", instance=options.get("--instance"), settings=settings)


def quiet(phase: str, done: int, total: int) -> None:
    """Show no progress."""


def sampled(model: load.Loaded) -> list[Finding]:
    walk = Walk(model.model, 2000, 0)
    walk.run(quiet)
    check_returns(walk, quiet)
    return walk.findings


def sampled_with_a_bug(model: load.Loaded) -> list[Finding]:
    """Return what is found where the density of ``noisy`` takes too little for the value itself."""
    density = Evaluator.density

    def biased(self: Evaluator, dist: ir.Dist, frame: Frame, value: Array) -> Array:
        wrong = ir.Noisy(dist.type, dist.value, FIFTH) if isinstance(dist, ir.Noisy) else dist
        return density(self, wrong, frame, value)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Evaluator, "density", biased)
        walk = Walk(model.model, 2000, 0)
        walk.run(quiet)
        check_densities(walk, quiet)
        return [f for f in walk.findings if "near" in f.diagnostic.message]


def ranked_with_a_bug(model: load.Loaded) -> list[belief_findings.Finding]:
    """Return what is found where most true values lie at the ends of the belief."""
    ranks = Ranks([i / 1000 for i in range(0, 1000, 20)] + [0.005, 0.995] * 30)
    return belief_findings.findings(model.model, {"room.door": ranks}, Asked(len(ranks.values), "particle"))


def told(entry: Entry, example: Example) -> tuple[set[str], str]:
    """Return the codes of what is told of an example in the current folder, and the text."""
    try:
        model = imported("example.pomdp") if entry.code.startswith("E09") else loaded(example)
    except ModelError as error:
        return {d.code for d in error.diagnostics}, render_all(error.diagnostics, error.sources)
    if entry.code in SAMPLED and isinstance(model, load.Loaded):
        if entry.code == "C0501":
            ranked = ranked_with_a_bug(model)
            return {f.diagnostic.code for f in ranked}, "".join(f.render(model.sources) for f in ranked)
        if entry.code == "C0204":
            figures = {"beliefs": 10_000, "violations": 8231 if example is entry.wrong else 0}
            violated = bound_findings.findings(model.model, {"lower": figures})
            return {d.code for d in violated}, render_all(violated, model.sources)
        found = sampled(model) if entry.right else sampled_with_a_bug(model)
        return {f.diagnostic.code for f in found}, "\n".join(f.render(model.sources) for f in found)
    if entry.code.startswith("W") and isinstance(model, load.Loaded):
        return {d.code for d in model.warnings}, render_all(model.warnings, model.sources)
    if entry.code == "E0812" and isinstance(model, load.Loaded):
        found = not_enumerable(model.model)
        return {d.code for d in found}, render_all(found, model.sources)
    return set(), ""


def diagnose(case: Case) -> tuple[tuple[Diagnostic, ...], str]:
    """Return what is told of a case's file, which must be in the current folder, and the text."""
    try:
        load.load_any(case.name)
    except ModelError as error:
        return tuple(error.diagnostics), shown(render_all(error.diagnostics, error.sources))
    return (), ""


def shown(text: str) -> str:
    """Return a message as the corpus has it: long lines are cut."""
    return re.sub(r"(?m)^(.{160}).*$", r"\1 ...", text).rstrip("\n") + "\n"


def accept(of: Entry | Case, text: str) -> None:
    """Write what is said of an entry or a case into the corpus."""
    for path in FOLDER.rglob("*.toml"):
        parts = re.split(r"(?m)^(?=\[+\w+\]+$)", path.read_text())
        for number, part in enumerate(parts):
            if _describes(part, of):
                parts[number] = _SAYS.sub(lambda _: f"says = {_literal(text)}", part)
                path.write_text("".join(parts))
                return
    raise ValueError(f"the corpus has no such part: {of}")


def _literal(text: str) -> str:
    """Return TOML's literal of a text, over several lines if it can be."""
    return json.dumps(text, ensure_ascii=False) if "'''" in text else f"'''\n{text}'''"


def _describes(part: str, of: Entry | Case) -> bool:
    if isinstance(of, Entry):
        return part.startswith(f"[{of.code}]\n")
    return part.startswith(f"[[{of.code}]]\nwhat = {json.dumps(of.what, ensure_ascii=False)}\n")
