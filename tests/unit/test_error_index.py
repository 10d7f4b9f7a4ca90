"""Every diagnostic code has an example that shows it and a right one; docs/reference/errors is made of them.

``HYPGEN_UPDATE=1 pytest tests/unit/test_error_index.py`` writes its pages anew; review the difference.
"""

import itertools
import os
import re
import textwrap
from pathlib import Path

import pytest

from hypgen.cli import main
from hypgen.cli.show.error_index import BEGINNING, Entry, Example, entries
from hypgen.codegen.passes.enumerable import not_enumerable
from hypgen.dsl import ir, load
from hypgen.dsl.foreign import files, reader
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import Array, Frame
from hypgen.dsl.interpret.sampling.findings import Finding
from hypgen.dsl.interpret.sampling.sample_laws import check_densities, check_returns
from hypgen.dsl.interpret.sampling.sample_model import Walk
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.render import render_all
from hypgen.dsl.messages.source import Source
from hypgen.dsl.types import PROB

ROOT = Path(__file__).parent.parent.parent
PAGES = ROOT / "docs" / "reference" / "errors"
ENTRIES = entries()
FIFTH = ir.Const(PROB, 0.2)
SAMPLED = {"W04", *(code for code in ENTRIES if code.startswith("C"))}
CLASSES = {
    "E00": "Files and settings",
    "E01": "Syntax",
    "E02": "Names",
    "E03": "Types",
    "E04": "Inits and updates",
    "E05": "What agent and policy may know",
    "E06": "Ranges",
    "E07": "Draws",
    "E08": "Parts of a model",
    "E09": "Other formats",
    "W": "Warnings",
    "C": "Found by sampling",
}
HEADING = """\
# Messages

Every message of hypgen has a code. A page for each group of codes says what each code means. It
shows a model that has the mistake, what hypgen prints, and the model put right. `hypgen error CODE`
prints the same in the terminal. Tests make these pages from `cli/show/errors/`, which is the place
to change: `HYPGEN_UPDATE=1 pytest tests/unit/test_error_index.py`.
"""
GOES_ON = """\
## The examples

An example is the file `example.pomdp`. Unless it begins with `model`, `instance` or `library`, the
page leaves out its first line, `model Example`. The example goes on with the following
declarations, except those that it makes itself:
"""
GROUP = """\
# {title}

[All messages](README.md) | [how an example goes on](README.md#the-examples)
"""


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
            other = "# " + "x" * 4_000_000
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


def told(entry: Entry, example: Example) -> tuple[set[str], str]:
    """Return the codes of what is told of an example in the current folder, and the text."""
    try:
        model = imported("example.pomdp") if entry.code.startswith("E09") else loaded(example)
    except ModelError as error:
        return {d.code for d in error.diagnostics}, render_all(error.diagnostics, error.sources)
    if entry.code in SAMPLED and isinstance(model, load.Loaded):
        found = sampled(model) if entry.right else sampled_with_a_bug(model)
        return {f.diagnostic.code for f in found}, "\n".join(f.render(model.sources) for f in found)
    if entry.code.startswith("W") and isinstance(model, load.Loaded):
        return {d.code for d in model.warnings}, render_all(model.warnings, model.sources)
    if entry.code == "E0812" and isinstance(model, load.Loaded):
        found = not_enumerable(model.model)
        return {d.code for d in found}, render_all(found, model.sources)
    return set(), ""


@pytest.fixture(scope="module")
def messages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[set[str], str, set[str], str]]:
    """Return by code what is told of the wrong and of the right example."""
    result = {}
    before = Path.cwd()
    for entry in ENTRIES.values():
        both: list[tuple[set[str], str]] = []
        for kind, example in (("wrong", entry.wrong), ("right", entry.right)):
            if example is None:
                both.append((set(), ""))
                continue
            folder = tmp_path_factory.mktemp(f"{entry.code}-{kind}")
            prepare(entry, example, folder)
            os.chdir(folder)
            try:
                both.append(told(entry, example))
            finally:
                os.chdir(before)
        result[entry.code] = (*both[0], *both[1])
    return result


Messages = dict[str, tuple[set[str], str, set[str], str]]


def test_every_code_has_its_entry() -> None:
    files = [path for layer in ("dsl", "codegen", "cli") for path in (ROOT / layer).rglob("*.py")]
    code = re.compile(r'"([EC]0\d{3}|W0\d)"')
    used = {found for file in files for found in code.findall(file.read_text())}
    assert used == set(ENTRIES)


@pytest.mark.parametrize("code", ENTRIES)
def test_the_examples_show_the_mistake_and_its_correction(code: str, messages: Messages) -> None:
    wrong, text, right, rest = messages[code]
    assert wrong == {code}, text
    assert right == set(), rest


def block(example: Example) -> str:
    text = example.text.rstrip("\n")
    if example.options:
        text = f"# hypgen check example.pomdp {' '.join(example.options)}\n{text}"
    for name, other in example.named_files().items():
        if "\n" in other:
            text += f"\n\n# {name}:\n{other.rstrip()}"
    return f"```\n{text}\n```\n"


def wrapped(text: str) -> str:
    return textwrap.fill(text, 100, break_long_words=False, break_on_hyphens=False)


def pages(messages: Messages) -> dict[str, str]:
    """Return the pages of docs/reference/errors by name: the index and one for each group of codes."""
    result, index = {}, [HEADING]
    for prefix, title in CLASSES.items():
        group = [entry for entry in ENTRIES.values() if entry.code.startswith(prefix)]
        parts, rows = [GROUP.format(title=title)], ["| code | meaning |", "|---|---|"]
        for entry in group:
            shown = re.sub(r"(?m)^(.{160}).*$", r"\1 ...", messages[entry.code][1]).rstrip("\n")
            parts += [f"## {entry.code}\n", f"{wrapped(entry.meaning)}\n"]
            parts += [block(entry.wrong), f"```\n{shown}\n```\n"]
            parts += ["Right:\n", block(entry.right)] if entry.right else []
            rows.append(f"| [{entry.code}]({prefix.lower()}.md#{entry.code.lower()}) | {entry.meaning} |")
        result[f"{prefix.lower()}.md"] = "\n".join(parts)
        index += [f"## [{title}]({prefix.lower()}.md)\n", *rows, ""]
    result["README.md"] = "\n".join([*index, GOES_ON, f"```\n{BEGINNING}```\n"])
    return result


def test_the_pages_are_up_to_date(messages: Messages) -> None:
    made = pages(messages)
    if os.environ.get("HYPGEN_UPDATE") == "1":
        for name, text in made.items():
            (PAGES / name).write_text(text)
    assert {path.name: path.read_text() for path in PAGES.iterdir()} == made


def test_a_code_is_explained_in_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["error", "e0301"]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("E0301: ") and "Right:\n\n    reward goal" in printed
    assert main.run(["error"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == len(ENTRIES)
    assert main.run(["error", "E9999"]) == 2
    assert "hypgen error lists" in capsys.readouterr().err
