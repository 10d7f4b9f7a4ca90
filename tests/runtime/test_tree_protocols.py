# SPDX-License-Identifier: Apache-2.0
"""The four protocols of a tree that several threads change without a lock (docs/internals/many-threads.md).

Small models of them, walked through in every order in which their threads' accesses to shared memory can
follow each other. A thread is a generator: it yields an access and is sent what that gave. It may return
`(generator function, arguments)` to go on as that, which forgets what has been read so far.
"""

from collections.abc import Callable, Generator, Iterable
from functools import cache
from typing import Any

import pytest

Memory = tuple[int, ...]
Access = Callable[[Memory], tuple[Memory, int]]
Thread = tuple[Callable[..., Generator[Access, int, Any]], tuple[Any, ...]]
Running = tuple[Thread, tuple[int, ...]] | None  # and what its accesses gave so far; None: it has ended


def put(memory: Memory, at: int, value: int) -> Memory:
    return (*memory[:at], value, *memory[at + 1 :])


def load(at: int) -> Access:
    return lambda memory: (memory, memory[at])


def store(at: int, value: int) -> Access:
    return lambda memory: (put(memory, at, value), value)


def exchange(at: int, value: int) -> Access:
    """Give the value before."""
    return lambda memory: (put(memory, at, value), memory[at])


def add(at: int, change: int) -> Access:
    return lambda memory: (put(memory, at, memory[at] + change), memory[at])


def lower_to(at: int, value: int) -> Access:
    return lambda memory: (put(memory, at, min(memory[at], value)), memory[at])


def raise_to(at: int, value: int) -> Access:
    return lambda memory: (put(memory, at, max(memory[at], value)), memory[at])


def compare_exchange(at: int, old: int, new: int) -> Access:
    """Give whether it worked."""
    return lambda memory: (put(memory, at, new), 1) if memory[at] == old else (memory, 0)


@cache
def resume(running: Running) -> tuple[Running, Access | None]:
    """Return a thread with its next access."""
    if running is None:
        return None, None
    (program, arguments), results = running
    generator = program(*arguments)
    try:
        access = next(generator)
        for result in results:
            access = generator.send(result)
    except StopIteration as end:
        return resume(end.value and (end.value, ()))
    return running, access


def ends(memory: Memory, threads: Iterable[Thread]) -> set[Memory]:
    """Return what the memory can be once all threads have ended."""
    found = set()
    first = (memory, tuple(resume((thread, ()))[0] for thread in threads))
    seen, waiting = {first}, [first]
    while waiting:
        memory, state = waiting.pop()
        if not any(state):
            found.add(memory)
        for i, running in enumerate(state):
            access = resume(running)[1]
            if running is None or access is None:
                continue
            after, result = access(memory)
            moved = resume((running[0], (*running[1], result)))[0]
            following = (after, (*state[:i], moved, *state[i + 1 :]))
            if following not in seen:
                seen.add(following)
                waiting.append(following)
    return found


# The maximum over a node's actions: their upper bounds are 0 .. ACTIONS - 1. They fall, but where a lower
# bound has crossed one.
ACTIONS = 3
BEST, LARGEST, NODE_UPPER, RISES = range(ACTIONS, ACTIONS + 4)


def move_action(action: int, change: int, variant: str) -> Generator[Access, int, Any]:
    yield add(action, change)
    if change > 0:
        yield add(RISES, 1)
        return begin_scan, (variant,)
    if (yield load(BEST)) == action:
        return begin_scan, (variant,)
    return take_over, (variant,)


def begin_scan(variant: str) -> Generator[Access, int, Any]:
    rises = yield load(RISES)
    before = yield load(LARGEST)
    return scan, (0, -1, -1, rises, before, variant)


def scan(
    action: int, largest: int, best: int, rises: int, before: int, variant: str
) -> Generator[Access, int, Any]:
    upper = yield load(action)
    if upper > largest:
        largest, best = upper, action
    if action + 1 < ACTIONS:
        return scan, (action + 1, largest, best, rises, before, variant)
    yield store(BEST, best)
    if variant != "no second look" and (yield load(best)) < largest:
        return begin_scan, (variant,)
    if variant == "unchanged unseen" and largest == before:
        return take_over, (variant,)
    if not (yield compare_exchange(LARGEST, before, largest)):
        return begin_scan, (variant,)
    if variant != "no scan after raising" and largest > before:
        return begin_scan, (variant,)
    if variant != "rises unseen" and (yield load(RISES)) != rises:
        return begin_scan, (variant,)
    return take_over, (variant,)


def take_over(variant: str) -> Generator[Access, int, Any]:
    upper = yield load((yield load(BEST)) if variant == "from the best action" else LARGEST)
    yield lower_to(NODE_UPPER, upper)


def wrong_maxima(changes: list[tuple[int, int]], variant: str) -> list[Memory]:
    threads = [(move_action, (*change, variant)) for change in changes]
    found = ends((10, 8, 6, 0, 10, 10, 0), threads)
    # What a crossing lifts again the node may have taken over before: an upper bound stays as low as it was.
    kept = [LARGEST] if any(change > 0 for _, change in changes) else [LARGEST, NODE_UPPER]
    return [end for end in found if {end[end[BEST]], *(end[at] for at in kept)} != {max(end[:ACTIONS])}]


LOWERED = [
    [(0, -7), (1, -6)],
    [(0, -7), (1, -6), (2, -5)],
    [(0, -9), (1, -7), (2, -5)],
    [(0, -4), (0, -3), (1, -6)],
    [(0, -6), (1, -7), (0, -2)],
]
RAISED = [
    [(0, -7), (1, 1)],
    [(0, -7), (1, 1), (2, 4)],
    [(0, -7), (1, 4), (1, -6)],
    [(0, -3), (1, 4), (0, -4)],
    [(1, 4), (1, -6), (2, 5)],
]


@pytest.mark.parametrize("changes", LOWERED + RAISED)
def test_best_and_largest_are_the_maximum(changes: list[tuple[int, int]]) -> None:
    assert not wrong_maxima(changes, "")


@pytest.mark.parametrize(
    "variant",
    ["no second look", "from the best action", "no scan after raising", "rises unseen", "unchanged unseen"],
)
def test_a_maximum_goes_wrong(variant: str) -> None:
    assert any(wrong_maxima(changes, variant) for changes in LOWERED + RAISED)


# Closing: a root with one child, which has two leaves; the memory is whether each is closed.
ROOT, INNER, LEAF, OTHER_LEAF = range(4)
PARENT = {ROOT: None, INNER: ROOT, LEAF: INNER, OTHER_LEAF: INNER}
CHILDREN = {ROOT: [INNER], INNER: [LEAF, OTHER_LEAF]}


def walk(node: int, variant: str) -> Generator[Access, int, Any]:
    """A trial at a node: it would take a child that is open."""
    is_closed = yield load(node)
    if not is_closed:
        for child in CHILDREN[node]:
            if not (yield load(child)):
                return None
        yield store(node, 1)
        if variant != "no second look":
            for child in CHILDREN[node]:
                if not (yield load(child)):
                    yield store(node, 0)
                    return None if variant == "no going up" else (open_up, (PARENT[node],))
    return None if PARENT[node] is None else (walk, (PARENT[node], variant))


def open_leaf(leaf: int) -> Generator[Access, int, Any]:
    yield store(leaf, 0)
    return open_up, (PARENT[leaf],)


def open_up(node: int | None) -> Generator[Access, int, Any]:
    if node is not None and (yield load(node)):
        yield store(node, 0)
        return open_up, (PARENT[node],)
    return None


def lost_subtrees(walks: list[int], opened: list[int], variant: str) -> list[Memory]:
    threads: list[Thread] = [(walk, (node, variant)) for node in walks]
    found = ends((0, 0, 1, 1), [*threads, *((open_leaf, (leaf,)) for leaf in opened)])
    return [end for end in found if any(end[n] and not all(end[c] for c in CHILDREN[n]) for n in CHILDREN)]


WALKS = [
    ([INNER], [LEAF]),
    ([INNER, INNER], [LEAF]),
    ([INNER, INNER, ROOT], [LEAF]),
    ([INNER, INNER], [LEAF, OTHER_LEAF]),
    ([INNER, ROOT], [LEAF, OTHER_LEAF]),
]


@pytest.mark.parametrize("walks,opened", WALKS)
def test_no_open_node_is_below_a_closed_one(walks: list[int], opened: list[int]) -> None:
    assert not lost_subtrees(walks, opened, "")


@pytest.mark.parametrize("variant", ["no second look", "no going up"])
def test_a_subtree_is_lost(variant: str) -> None:
    assert any(lost_subtrees(walks, opened, variant) for walks, opened in WALKS)


# Crossing: a child's bounds, and the sum at its parent's action, to which every change has to be added once.
LOWER, UPPER, SUM = range(3)


def raise_lower(value: int, variant: str) -> Generator[Access, int, Any]:
    yield raise_to(LOWER, value)
    return None if variant == "no look across" else (lift, ())


def fall(value: int, variant: str) -> Generator[Access, int, Any]:
    upper = yield load(UPPER)
    lower = yield load(LOWER)
    new = max(lower, min(upper, value))
    if new != upper:
        if not (yield compare_exchange(UPPER, upper, new)):
            return fall, (value, variant)
        yield add(SUM, new - upper)
    return None if variant == "no look across" else (lift, ())


def lift() -> Generator[Access, int, Any]:
    """Bring the upper bound up to the lower one."""
    lower = yield load(LOWER)
    upper = yield load(UPPER)
    if upper < lower:
        if not (yield compare_exchange(UPPER, upper, lower)):
            return lift, ()
        yield add(SUM, lower - upper)
    return None


def wrong_bounds(lowers: list[int], uppers: list[int], variant: str) -> list[Memory]:
    threads: list[Thread] = [(raise_lower, (lower, variant)) for lower in lowers]
    found = ends((1, 10, 10), [*threads, *((fall, (upper, variant)) for upper in uppers)])
    return [end for end in found if end != (max(lowers),) * 3]


@pytest.mark.parametrize("lowers,uppers", [([6], [4]), ([6, 8], [4]), ([6], [4, 2]), ([3, 6], [4, 2])])
def test_crossed_bounds_meet(lowers: list[int], uppers: list[int]) -> None:
    assert not wrong_bounds(lowers, uppers, "")


def test_bounds_stay_crossed_if_nobody_looks_across() -> None:
    assert wrong_bounds([6], [4], "no look across")


# Claiming a leaf: whether it is expanded, whether it is closed, how often it has been expanded.
EXPANDED, CLOSED, EXPANSIONS = range(3)


def claim(variant: str) -> Generator[Access, int, Any]:
    if (yield load(EXPANDED)) or (yield load(CLOSED)) or (yield exchange(CLOSED, 1)):
        return
    if variant == "no second look" or not (yield load(EXPANDED)):
        yield add(EXPANSIONS, 1)
        yield store(EXPANDED, 1)
    yield store(CLOSED, 0)


@pytest.mark.parametrize("threads", [2, 3, 4])
def test_a_leaf_is_expanded_once(threads: int) -> None:
    assert ends((0, 0, 0), [(claim, ("",))] * threads) == {(1, 0, 1)}


def test_a_leaf_is_expanded_twice_without_a_second_look() -> None:
    assert (1, 0, 2) in ends((0, 0, 0), [(claim, ("no second look",))] * 2)
