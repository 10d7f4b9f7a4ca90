# SPDX-License-Identifier: Apache-2.0
"""Expressions of the IR, evaluated over all lanes at once.

Both sides of a conditional are computed and the right one is chosen for each lane, except where the
condition is the same in all lanes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.joint_values import everywhere
from hypgen.dsl.interpret.evaluate.moments import POINTS, Law, Points, Sums
from hypgen.dsl.interpret.evaluate.values import (
    Array,
    Frame,
    History,
    State,
    Word,
    as_type,
    combinations,
    dtype_of,
    from_position,
    to_position,
)
from hypgen.dsl.interpret.floats import exponentials, normal, scalar_functions, trigonometry
from hypgen.dsl.types import Int, Type, size_of

_BINARY: dict[str, Callable[[Any, Any], Any]] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "floordiv": scalar_functions.floordiv,
    "mod": scalar_functions.mod,
    "pow": exponentials.pow,
    "min": scalar_functions.minimum,
    "max": scalar_functions.maximum,
    "hypot": exponentials.hypot,
    "atan2": trigonometry.atan2,
    "eq": np.equal,
    "ne": np.not_equal,
    "lt": np.less,
    "le": np.less_equal,
    "gt": np.greater,
    "ge": np.greater_equal,
    "and": np.logical_and,
    "or": np.logical_or,
}
_UNARY: dict[str, Callable[[Any], Any]] = {
    "neg": np.negative,
    "not": np.logical_not,
    "abs": np.abs,
    "sign": scalar_functions.sign,
    "sqrt": exponentials.sqrt,
    "exp": exponentials.exp,
    "log": exponentials.log,
    "log2": exponentials.log2,
    "normal_cdf": normal.normal_cdf,
    "sin": trigonometry.sin,
    "cos": trigonometry.cos,
    "tan": trigonometry.tan,
    "asin": trigonometry.asin,
    "acos": trigonometry.acos,
}
_TO_INT: dict[str, Callable[[Any, int, int], Any]] = {
    "floor": scalar_functions.floor_to_int,
    "ceil": scalar_functions.ceil_to_int,
    "round": scalar_functions.round_to_int,
}


class Expressions:
    """The values of a model's expressions, given its params."""

    def __init__(self, model: ir.Model, params: Mapping[str, Sequence[Any]]) -> None:
        self.model = model
        self.variables = {v.name: v for v in model.variables}
        self._policy_lets = {let.name for let in model.policy.lets} if model.policy else set()
        self._lets = {x.name: x for x in model.all_lets}
        self._registers = {r.name: r for r in model.history.registers}
        self._observed = {o.name: tuple(b.type for b in o.binders) for o in model.observations}
        self._functions = {f.name: f for f in model.functions}
        self._params = {p.name: (p, _entries(p.name, p, params.get(p.name, p.default))) for p in model.params}
        self._tables = {t.name: (t, _entries(t.name, t, t.values)) for t in model.tables}
        self._handlers: dict[type[ir.Expr], Callable[[Any, Frame], Any]] = {
            ir.Const: lambda e, frame: as_type(e.value, e.type),
            ir.Local: lambda e, frame: frame.locals[e.name],
            ir.ParamRead: lambda e, frame: self._entry(self._params[e.param], e.indices, frame),
            ir.TableRead: lambda e, frame: self._entry(self._tables[e.table], e.indices, frame),
            ir.StateRead: self._state_read,
            ir.LetRead: self._let_read,
            ir.ActionRead: lambda e, frame: self._component(frame.action, e.indices, frame),
            ir.MemoryRead: self._memory_read,
            ir.LastObservation: self._last_observation,
            ir.LastAction: self._last_action,
            ir.BeliefRead: self._belief_read,
            ir.Call: self._call,
            ir.ToFloat: lambda e, frame: self.value(e.operand, frame).astype(np.float32),
            ir.Unary: self._unary,
            ir.Binary: self._binary,
            ir.Clamp: self._clamp,
            ir.Checked: self._clamp,
            ir.If: self._if,
            ir.LetIn: lambda e, frame: self.value(e.body, frame.bind({e.name: self.value(e.value, frame)})),
            ir.IsVariant: self._is_variant,
            ir.VariantArgument: self._variant_argument,
            ir.MakeVariant: self._make_variant,
            ir.FieldRead: self._field_read,
            ir.MakeRecord: self._make_record,
            ir.Quantified: self._quantified,
        }

    def value(self, e: ir.Expr, frame: Frame) -> Array:
        """Return the expression's value in each lane, or a scalar that all lanes share."""
        result: Array = self._handlers[type(e)](e, frame)
        return result

    def sample(self, dist: ir.Dist, frame: Frame, word: Word) -> Array:
        """Return a draw from the distribution in each lane."""
        raise NotImplementedError

    def where(self, condition: Array, evaluate: Callable[[], Array]) -> Array:
        """Return what ``evaluate`` gives, which matters only where the condition holds.

        The other lanes hold garbage; who watches an evaluation for what goes wrong in it needs to know.
        """
        return evaluate()

    # Reads -----------------------------------------------------------------------------------

    def _places(
        self, types: tuple[Type, ...], indices: tuple[ir.Expr, ...], frame: Frame
    ) -> tuple[Array, ...]:
        return tuple(to_position(self.value(i, frame), t) for i, t in zip(indices, types, strict=True))

    def _entry(
        self, table: tuple[ir.Param | ir.ConstantArray, Array], indices: tuple[ir.Expr, ...], frame: Frame
    ) -> Array:
        declaration, entries = table
        result: Array = entries[self._places(declaration.indices, indices, frame)]
        return result

    def _state_read(self, e: ir.StateRead, frame: Frame) -> Array:
        variable = self.variables[e.variable]
        after = (e.primed or frame.primed) and not variable.fixed
        state = frame.after if after else frame.state
        assert state is not None, "only a step has a next state"
        places = self._places(variable.indices, e.indices, frame)
        common = all(p.ndim == 0 for p in places)
        result: Array = state[e.variable][(slice(None) if common else frame.lanes, *places)]
        return result

    def _let_read(self, e: ir.LetRead, frame: Frame) -> Array:
        if e.let not in self._policy_lets:
            return self._let_value(e, frame)
        if e.let not in frame.decided:
            frame.decided[e.let] = self._let_value(e, frame)
        return frame.decided[e.let]

    def _let_value(self, e: ir.LetRead, frame: Frame) -> Array:
        let = self._lets[e.let]
        binders = () if let.binder is None else (let.binder,)
        values = {b.name: self.value(i, frame) for b, i in zip(binders, e.indices, strict=True)}
        inner = frame.enter(values, e.primed)
        if isinstance(let.dist, ir.Certain):
            return self.value(let.dist.value, inner)
        index: int | Array = 0
        if let.binder is not None:
            place = to_position(values[let.binder.name], let.binder.type)
            index = int(place) if place.ndim == 0 else place
        return self.sample(let.dist, inner, frame.word(let.site.id, index))

    def _component(self, code: Array | None, indices: tuple[ir.Expr, ...], frame: Frame) -> Array:
        """Return the action of the joint action's code, or its component at ``indices``."""
        action = self.model.action
        assert code is not None, "there is no action here"
        size = size_of(action.type)
        shape = tuple(size_of(t) for t in action.indices)
        component = np.zeros((), dtype=np.int64)
        for place, length in zip(self._places(action.indices, indices, frame), shape, strict=True):
            component = component * length + place
        strides = np.array([size**i for i in reversed(range(math.prod(shape)))], dtype=np.int64)
        return from_position(code // strides[component] % size, action.type)

    def _memory_read(self, e: ir.MemoryRead, frame: Frame) -> Array:
        return self._kept(f"memory {e.register}", self._registers[e.register].indices, e.indices, frame)

    def _last_observation(self, e: ir.LastObservation, frame: Frame) -> Array:
        seen = self._kept(f"last {e.observation}", self._observed[e.observation], e.indices, frame)
        return np.where(_history(frame)["started"], seen, self.value(e.first, frame))

    def _last_action(self, e: ir.LastAction, frame: Frame) -> Array:
        done = self._component(_history(frame)["action"], e.indices, frame)
        return np.where(_history(frame)["started"], done, self.value(e.first, frame))

    def _belief_read(self, e: ir.BeliefRead, frame: Frame) -> Array:
        factor = next(f for f in self.model.factors if f.element == e.element)
        member = np.asarray(0)
        if e.index is not None and factor.binder is not None:
            member = to_position(self.value(e.index, frame), factor.binder.type)
        known: Array = _history(frame)[f"belief {e.element}"][frame.lanes, member]
        if factor.holds(e) and factor.moments is not None:
            number: Array = known[:, int(e.deviation)]
            return number
        if factor.moments is None and not e.deviation:
            total = np.zeros(len(frame.lanes), dtype=np.float32)
            for h in range(factor.size):
                state = everywhere(self.model, factor, h, frame.state)
                share = known[:, h] * self.value(e.operand, replace(frame, state=state))
                total = np.where(known[:, h] > 0, total + share, total)
            return total
        sums = Sums(len(frame.lanes))
        for state, weight in self._hypotheses(factor, member, known, frame):
            sums.add(weight, self.value(e.operand, replace(frame, state=state)).astype(np.float64))
        return (sums.deviation() if e.deviation else sums.mean()).astype(np.float32)

    def _hypotheses(
        self, factor: ir.Factor, member: Array, known: Array, frame: Frame
    ) -> Iterator[tuple[State, Array]]:
        """Yield what a belief's state may be, and how likely it is: float64, not normalised."""
        if factor.moments is None:
            for h in range(factor.size):
                yield everywhere(self.model, factor, h, frame.state), known[:, h].astype(np.float64)
            return
        law, name = Law(known, self.ends(factor, member, frame)), factor.moments.variable
        points, shape = Points(law, law.mean, law.deviation), frame.state[name].shape
        for k in range(POINTS):
            x = points.at(k)
            all_members = np.broadcast_to(x.reshape(-1, *[1] * (len(shape) - 1)), shape)
            yield {**frame.state, name: all_members}, law.density(x)

    def ends(self, factor: ir.Factor, member: Array, frame: Frame) -> tuple[Array, Array] | None:
        """Return the range that the float at a position of a factor never leaves, if it has one."""
        assert factor.moments is not None
        if factor.moments.ends is None:
            return None
        own = {} if factor.binder is None else {factor.binder.name: from_position(member, factor.binder.type)}
        low, high = (self.value(e, frame.enter(own, False)) for e in factor.moments.ends)
        return low, high

    def _kept(self, name: str, types: tuple[Type, ...], indices: tuple[ir.Expr, ...], frame: Frame) -> Array:
        result: Array = _history(frame)[name][(frame.lanes, *self._places(types, indices, frame))]
        return result

    def _call(self, e: ir.Call, frame: Frame) -> Array:
        function = self._functions[e.function]
        pairs = zip(function.formals, e.arguments, strict=True)
        values = {formal.name: self.value(argument, frame) for formal, argument in pairs}
        return self.value(function.body, frame.enter(values, e.primed))

    # Operators -------------------------------------------------------------------------------

    def _unary(self, e: ir.Unary, frame: Frame) -> Array:
        operand = self.value(e.operand, frame)
        if e.op in _TO_INT:
            assert isinstance(e.type, Int)
            return as_type(_TO_INT[e.op](operand, e.type.low, e.type.high), e.type)
        return as_type(_UNARY[e.op](operand), e.type)

    def _binary(self, e: ir.Binary, frame: Frame) -> Array:
        left = self.value(e.left, frame)
        if e.op in ("and", "or") and left.ndim == 0 and bool(left) == (e.op == "or"):
            return left
        if e.op in ("and", "or"):
            matters = left if e.op == "and" else np.logical_not(left)
            right = self._where_value(matters, e.right, frame)
        else:
            right = self.value(e.right, frame)
        return as_type(_BINARY[e.op](left, right), e.type)

    def _clamp(self, e: ir.Clamp, frame: Frame) -> Array:
        low, high = as_type(e.low, e.type), as_type(e.high, e.type)
        return as_type(scalar_functions.clamp(self.value(e.operand, frame), low, high), e.type)

    def _if(self, e: ir.If, frame: Frame) -> Array:
        condition = self.value(e.condition, frame)
        if condition.ndim == 0:
            return self.value(e.then if condition else e.otherwise, frame)
        then = self._where_value(condition, e.then, frame)
        otherwise = self._where_value(~condition, e.otherwise, frame)
        return np.where(condition, then, otherwise)

    # Enums and records -----------------------------------------------------------------------

    def _is_variant(self, e: ir.IsVariant, frame: Frame) -> Array:
        offset = self.value(e.operand, frame) - np.int32(e.enum.offsets[e.variant])
        argument = _argument_type(e)
        return np.asarray((offset >= 0) & (offset < (1 if argument is None else size_of(argument))))

    def _variant_argument(self, e: ir.VariantArgument, frame: Frame) -> Array:
        argument = _argument_type(e)
        assert argument is not None
        offset = self.value(e.operand, frame) - np.int32(e.enum.offsets[e.variant])
        # Lanes with another variant hold garbage.
        return from_position(np.minimum(np.maximum(offset, 0), size_of(argument) - 1), argument)

    def _make_variant(self, e: ir.MakeVariant, frame: Frame) -> Array:
        argument = _argument_type(e)
        assert argument is not None
        return as_type(
            to_position(self.value(e.argument, frame), argument) + e.enum.offsets[e.variant], e.enum
        )

    def _field_read(self, e: ir.FieldRead, frame: Frame) -> Array:
        t = e.record.field_type(e.field)
        assert t is not None
        return from_position(self.value(e.operand, frame) // e.record.stride(e.field) % size_of(t), t)

    def _make_record(self, e: ir.MakeRecord, frame: Frame) -> Array:
        code = np.zeros((), dtype=np.int64)
        for (_, t), value in zip(e.record.fields, e.values, strict=True):
            code = code * size_of(t) + to_position(self.value(value, frame), t)
        return as_type(code, e.type)

    # Quantifiers -----------------------------------------------------------------------------

    def _quantified(self, e: ir.Quantified, frame: Frame) -> Array:
        if e.kind in ("min", "max", "argmin", "argmax"):
            return self._extremum(e, frame)
        total = as_type(e.kind == "all", e.type)
        for _, _, values in combinations(e.binders):
            inner = frame.bind(values)
            match = self.holds(e.condition, inner)
            if match.ndim == 0 and not match:
                continue
            body = as_type(1, e.type) if e.body is None else self._where_value(match, e.body, inner)
            match e.kind:
                case "any":
                    total = total | (match & body)
                case "all":
                    total = total & (~match | body)
                case _:  # sum, count
                    total = as_type(np.where(match, total + body, total), e.type)
        return total

    def _extremum(self, e: ir.Quantified, frame: Frame) -> Array:
        """Return the least or greatest body, or the binder's value that has it; the first of equals wins."""
        assert e.body is not None
        best = result = found = None
        for _, _, values in combinations(e.binders):
            inner = frame.bind(values)
            match = self.holds(e.condition, inner)
            body = self._where_value(match, e.body, inner)
            candidate = values[e.binders[0].name] if e.kind.startswith("arg") else body
            if best is None or result is None or found is None:
                best, result, found = body, candidate, match  # also what stands in where nothing matches
                continue
            better = body < best if e.kind.endswith("min") else best < body
            take = match & (~found | better)
            best, result = np.where(take, body, best), np.where(take, candidate, result)
            found = found | match
        assert result is not None and found is not None, "a finite type has values"
        if e.otherwise is not None:
            result = np.where(found, result, self._where_value(~found, e.otherwise, frame))
        return as_type(result, e.type)

    def _where_value(self, condition: Array, e: ir.Expr, frame: Frame) -> Array:
        return self.where(condition, lambda: self.value(e, frame))

    def holds(self, condition: ir.Expr | None, frame: Frame) -> Array:
        """Return where a condition holds; no condition always does."""
        return np.asarray(np.True_) if condition is None else self.value(condition, frame)


def _history(frame: Frame) -> History:
    assert frame.history is not None, "only the policy and bound lower read the history"
    return frame.history


def _argument_type(e: ir.IsVariant | ir.VariantArgument | ir.MakeVariant) -> Type | None:
    variant = e.enum.variant(e.variant)
    assert variant is not None
    return variant.argument


def _entries(
    name: str, declaration: ir.Param | ir.ConstantArray, values: Sequence[Any] | Any | None
) -> Array:
    """Return a param's or constant array's entries in its shape."""
    if values is None:
        raise ValueError(f"param {name} has no default and was not given")
    shape = tuple(size_of(t) for t in declaration.indices)
    entries = np.asarray(values).astype(dtype_of(declaration.type))
    if entries.size != math.prod(shape):
        raise ValueError(f"{name} takes {math.prod(shape)} values, not {entries.size}")
    return entries.reshape(shape)
