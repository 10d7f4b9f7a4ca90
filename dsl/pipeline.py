"""From the syntax tree to a checked model: the order in which declarations are taken up."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import PurePath

from hypgen.dsl import ir
from hypgen.dsl.analysis import init_order, stages
from hypgen.dsl.analysis.factorise import factorise
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.check import lint
from hypgen.dsl.check.constants import settings
from hypgen.dsl.check.expressions import belief_reads
from hypgen.dsl.check.parts import derived_bounds, model_parts, policies
from hypgen.dsl.check.program import CheckedProgram
from hypgen.dsl.check.records.flatten_records import flatten
from hypgen.dsl.check.scope.scope import Program
from hypgen.dsl.check.scope.symbols import collect
from hypgen.dsl.check.visibility import check_reads
from hypgen.dsl.ir import operators
from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.report import Report, mistake
from hypgen.dsl.messages.source import Source, Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Enum, Record, is_finite

# The parser limits nesting; each level takes some ten frames here.
_RECURSION_LIMIT = 20_000
_ZERO = operators.real(0.0)


def lower(
    file: ast.ModelFile,
    overrides: Mapping[str, ast.Expr],
    source: Source,
    imported: Sequence[Source] = (),
    warned: list[Diagnostic] | None = None,
) -> ir.Model:
    """Return the checked model; raises ``ModelError`` with every independent mistake.

    ``imported`` are the texts of the libraries whose items ``file`` has taken in. Warnings go to ``warned``.
    """
    written = file
    with _deep_recursion():
        report = Report()
        file, overrides = flatten(file, overrides, report)
        report.raise_if_any()
        program = CheckedProgram(file, overrides, collect(file, report), report)
        settings.refuse_unknown(program)
        model = _model(program, (source, *imported))
        report.raise_if_any()
        assert model is not None
        if warned is not None:
            warned += lint.warnings(written, model, program)
        return model


def check_library(file: ast.LibraryFile) -> None:
    """Check a library by itself; raises ``ModelError`` with every independent mistake."""
    with _deep_recursion():
        report = Report()
        alone, _ = flatten(ast.ModelFile(file.span, file.name, file.items), {}, report)
        report.raise_if_any()
        _Declared(CheckedProgram(alone, {}, collect(alone, report), report))
        report.raise_if_any()


@contextmanager
def _deep_recursion() -> Iterator[None]:
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(max(before, _RECURSION_LIMIT))
    try:
        yield
    finally:
        sys.setrecursionlimit(before)


def _model(program: Program, sources: Sequence[Source]) -> ir.Model | None:
    report = program.report
    declared = _Declared(program)
    action = report.attempt(partial(_action, program))
    discount = report.attempt(partial(program.discount, program.file.span))
    horizon = report.attempt(partial(settings.horizon, program))
    inits, updates = model_parts.assignments(program)
    observations = model_parts.observations(program)
    rewards = model_parts.rewards(program)
    conditions = {
        kind: report.attempt(partial(model_parts.condition, program, kind)) for kind in model_parts.CONDITIONS
    }
    policy = None if action is None else report.attempt(partial(policies.policy, program, action))
    found_bounds = model_parts.bounds(program)
    history = policies.history(program, observations)

    variables = {v.name: v for v in declared.variables}
    invariants = model_parts.invariants(program)
    lint.check_float_equalities(program)
    check_reads(program, variables, _readers(program, inits, found_bounds, invariants))
    updates = stages.stage_updates(updates, program.uses, report)
    inits = init_order.order_inits(inits, variables, declared.definitions(program), program.uses, report)
    sites = [(a.site, a.span) for a in (*inits, *updates)]
    sites += [(o.site, o.span) for o in observations]
    policy_lets = () if policy is None else policy.lets
    sites += [(x.site, x.span) for x in (*declared.lets, *policy_lets) if x.draws]
    stages.check_sites(sites + [(ir.Site("policy:default"), program.file.span)], report)
    watched = [*(Owner("observe", o.name) for o in observations), Owner("terminal")]
    marked = stages.mark_variables(declared.variables, updates, program.uses, watched)
    updated = {u.variable for u in updates}  # an update with a mistake of its own is not among them
    floats = [v for v in marked if v.name in updated]
    stages.check_visible_floats(floats, program.uses, watched, report)
    key = stages.key_fields(observations, marked)
    stages.check_key(key, program.file.span, report)
    if report.found or action is None or discount is None:
        return None

    model = ir.Model(
        name=program.file.name,
        file=PurePath(sources[0].name).name,
        source_hash=_hash(sources, program),
        discount=discount,
        horizon=horizon,
        enums=tuple(declared.enums),
        records=tuple(declared.records),
        params=tuple(declared.params),
        tables=(*declared.tables, *program.literals),
        elements=tuple(declared.elements),
        variables=tuple(marked),
        lets=tuple(declared.lets),
        functions=(*declared.functions, *program.unrolled.values()),
        action=action,
        inits=tuple(inits),
        updates=tuple(updates),
        observations=tuple(observations),
        rewards=tuple(rewards),
        terminal=conditions["terminal"] or operators.FALSE,
        legal=conditions["legal"] or operators.TRUE,
        policy=policy,
        upper=found_bounds.get("upper", _ZERO),
        tail=found_bounds.get("tail", _ZERO),
        lower=found_bounds.get("lower"),
        success=conditions["success"],
        key=key,
        history=history,
        invariants=tuple(invariants),
        spans=_spans(program.file),
    )
    for name in ("upper", "tail"):
        if name not in found_bounds:
            bound = report.attempt(partial(derived_bounds.derived, name, model, program))
            model = replace(model, **{name: bound or _ZERO})  # type: ignore[arg-type]  # both are expressions
    factors, obstacles = factorise(model, program.uses)
    return belief_reads.resolved(replace(model, factors=factors, obstacles=obstacles), program)


class _Declared:
    """All declarations, checked; those with mistakes are reported and left out."""

    def __init__(self, program: Program) -> None:
        self.enums: list[Enum] = []
        self.records: list[Record] = []
        self.params: list[ir.Param] = []
        self.tables: list[ir.ConstantArray] = []
        self.elements: list[ir.Element] = []
        self.variables: list[ir.Variable] = []
        self.lets: list[ir.Let] = []
        self.functions: list[ir.Function] = []
        for item in program.symbols.globals.values():
            program.report.attempt(partial(self._add, item, program))

    def definitions(self, program: Program) -> init_order.Definitions:
        """Return what reads of state may go through."""
        lets = {x.name: x for x in self.lets}
        functions = {f.name: f for f in self.functions} | program.unrolled
        families = frozenset(e.name for e in self.elements if e.binder is not None)
        return init_order.Definitions(lets, functions, families)

    def _add(self, item: ast.Item, program: Program) -> None:
        match item:
            case ast.TypeAlias() | ast.EnumDecl() | ast.RecordDecl():
                found = program.named_type(item)
                if isinstance(found, Enum) and found not in self.enums:
                    self.enums.append(found)
                if isinstance(found, Record) and is_finite(found) and found not in self.records:
                    self.records.append(found)
            case ast.Const():
                value = program.const(item)
                if isinstance(value, ir.ConstantArray):
                    self.tables.append(value)
            case ast.Param():
                self.params.append(program.param(item))
            case ast.Function(rhs=ast.Rhs(draw=True)):
                program.named_distribution(item)
            case ast.Function(_, name) if name not in program.recursive:
                self.functions.append(program.function(item))
            case ast.Element(_, name):
                self.elements.append(program.element(name))
                for member in program.symbols.members[name].values():
                    program.report.attempt(partial(self._add_member, name, member, program))

    def _add_member(self, element: str, member: ast.Variable | ast.Let, program: Program) -> None:
        if isinstance(member, ast.Variable):
            self.variables.append(program.variable(element, member))
        else:
            self.lets.append(program.let(element, member))


def _action(program: Program) -> ir.Action:
    items = [i for i in program.file.items if isinstance(i, ast.Action)]
    if not items:
        raise mistake("E0801", "the model has no action", program.file.span, "add a line: action act: Act")
    if len(items) > 1:
        raise mistake(
            "E0802",
            "the model has a second action",
            items[1].span,
            "there is one: join the two in a record, or in an array if they are alike",
            [(items[0].span, "the first action is here")],
        )
    return program.action(items[0])


def _readers(
    program: Program,
    inits: list[ir.Assign],
    found_bounds: Mapping[str, ir.Expr],
    invariants: list[ir.Invariant],
) -> list[Owner]:
    """Return the declarations that may not read everything."""
    return [
        *(Owner("init", i.variable) for i in inits),
        Owner("legal"),
        *policies.readers(program),
        *(Owner("bound", name) for name in found_bounds),
        *(Owner("invariant", i.name) for i in invariants),
    ]


def _hash(sources: Sequence[Source], program: Program) -> str:
    """Return the SHA-256 of the texts and, in order of names, the values that settings replace."""
    digest = hashlib.sha256("\n".join(s.text for s in sources).encode())
    for name in sorted(program.overrides):
        item = program.symbols.globals[name]
        value: object = None
        if isinstance(item, ast.Param):
            value = program.param(item).default
        elif isinstance(item, ast.Const):
            found = program.const(item)
            value = found.values if isinstance(found, ir.ConstantArray) else found.value
        digest.update(f"\n{name} = {value!r}".encode())
    return digest.hexdigest()


def _spans(file: ast.ModelFile) -> dict[str, Span]:
    """Return where the model's nameless parts are declared: ``terminal``, ``policy``, ``upper`` ..."""
    spans: dict[str, Span] = {}
    for item in file.items:
        match item:
            case ast.Condition(span, kind) | ast.Setting(span, kind):
                spans.setdefault(kind, span)
            case ast.Bound(span, name):
                spans.setdefault(name, span)
            case ast.Policy(span):
                spans.setdefault("policy", span)
    return spans
