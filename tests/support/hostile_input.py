# SPDX-License-Identifier: Apache-2.0
"""Command lines and params files of every kind, wrong in most ways that text can be; the same for a seed."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from typing import Any

# What begins every line of options, so that little is reserved unless the line says otherwise, and what ends
# it, so that what is right is soon done.
SMALL = ("--memory", "16", "--particles", "100", "--scenarios", "50")
CAPS = ("--runs", "1", "--steps", "2", "--trials", "2")
TOGGLES = ("--quiet", "--details", "--signature", "--help", "--version", "--serve", "--require-gpu")
# Valid values that a machine in tests can afford; documented failures of files and memory are left out.
VALUES: dict[str, Callable[[random.Random], str]] = {
    "--mode": lambda r: r.choice(["despot", "parallel", "gpu", "hyp", "pomcp", "rollout", "default"]),
    "--runs": lambda r: str(r.randint(1, 10**6)),
    "--first-run": lambda r: str(r.randint(0, 10**9)),
    "--steps": lambda r: str(r.randint(1, 10**6)),
    "--time": lambda r: f"{r.uniform(1e-4, 1e6):g}",
    "--period": lambda r: f"{r.uniform(1e-4, 1e6):g}",
    "--trials": lambda r: str(r.randint(1, 2**64 - 1)),
    "--threads": lambda r: str(r.choice([1, 2, 3, 8])),
    "--in-flight": lambda r: str(r.choice([1, 2, 64, 4096])),
    "--observation-loss": lambda r: f"{r.uniform(0, 1e3):g}",
    "--exploration": lambda r: f"{r.uniform(0, 1e3):g}",
    "--device": lambda r: r.choice(["auto", "cpu", "cuda", "cuda:0", "cuda:1023"]),
    "--scenarios": lambda r: str(r.choice([1, 2, 50])),
    "--rollouts": lambda r: str(r.randint(1, 1 << 20)),
    "--depth": lambda r: str(r.choice([1, 2, 90])),
    "--xi": lambda r: f"{r.random():g}",
    "--pruning": lambda r: r.choice(["auto", "0", "1e9", f"{r.uniform(0, 10):g}"]),
    "--belief": lambda r: r.choice(["auto", "particle", "factored"]),
    "--particles": lambda r: str(r.choice([1, 2, 100, 5000])),
    "--on-depletion": lambda r: r.choice(["continue", "stop"]),
    "--memory": lambda r: str(r.choice([1, 2, 16, 64])),
    "--device-memory": lambda r: str(r.randint(1, 10**6)),
    "--seed": lambda r: str(r.randint(0, 2**64 - 1)),
    "--param": lambda r: r.choice(["/nowhere.json", "/", "/dev/null", "/dev/zero"]),
    "--world-param": lambda r: r.choice(["/nowhere.json", "/", "/dev/null", "/dev/zero"]),
    "--json": lambda r: r.choice(["-", "/dev/null"]),
}
ODD: tuple[bytes, ...] = tuple(
    text.encode()
    for text in (
        *("", " ", "-", "--", "=", "nan", "NaN", "-nan", "inf", "-inf", "Infinity", "null", "None", "true"),
        *("-1", "-0", "+1", "0", "00", "1 ", " 1", "1\n", "\t1", "1e3", "1e-400", "1e400", "-1e400", "0x10"),
        *("1,5", "1.5", "1_000", ".5", "5.", "1e", "1e+", "9" * 40, "0." + "9" * 400, "9" * 5000),
        *("18446744073709551615", "18446744073709551616", "4294967296", "2147483648", "-2147483649"),
        *(
            "٣",
            "½",
            "１",
            "café",
            "\N{ROBOT FACE}",
            "\N{RIGHT-TO-LEFT OVERRIDE}x",
            "\x1b[2J",
            "\x7f",
            "%s%n%n",
        ),
        *("auto", "cuda:", "cuda:-1", "cuda:1024", "cuda:99999999999", "despot,pomcp", "DESPOT", "--runs"),
        *("a" * 5000, "../" * 50, "~", "$HOME", "'", '"', "\\", "{}", "[" * 5000),
    )
) + (b"\xff", b"\xc3", b"\xed\xa0\x80", b"\xf5\x80\x80\x80", b"1\xff", b"\x80" * 100)
ODD_NAMES: tuple[bytes, ...] = tuple(
    text.encode()
    for text in ("", "-", "--", "---", "--=", "--=1", "runs", "-h", "--RUNS", "--run", "--é", "--runs ")
) + (b"--\xff", b"--" + b"x" * 3000)

# The params of tests/faults/knobs.pomdp, with values that they take.
PARAMS: dict[str, Callable[[random.Random], Any]] = {
    "hearing": lambda r: r.choice([0, 1, 0.5, r.random(), 1e-45]),
    "scale": lambda r: r.choice([0, -1.5, 3e38, -3e38, 1e-45, r.uniform(-10, 10), 2**31]),
    "weights": lambda r: r.choice([[[r.uniform(-1, 1)] * 3] * 2, [3e38] * 6, [0, 1, 2, 3, 4, 5]]),
    "rocks": lambda r: [r.randint(0, 2), r.randint(0, 2)],
    "favourite": lambda r: r.choice(["left", "right"]),
    "quiet": lambda r: r.random() < 0.5,
    "map": lambda r: r.choice([["..#", "#.."], [["floor"] * 3, "###"], [".", "#", ".", "#", ".", "#"]]),
}
ODD_VALUES: tuple[str, ...] = (
    *("null", "true", "{}", "[]", '""', "-0.0", "-1", "3", "1.5", "1e308", "-1e308", "1e-400", "1E+2"),
    *("18446744073709551615", "18446744073709551616", "-9223372036854775808", "2147483648", "9" * 400),
    *('"left "', '"up"', '"\\u0000"', '"\\ud83e\\udd16"', '"\\u001b[2J"', "[[[]]]", "[[1,2],[3]]", "[1,[2]]"),
    *('[["..#"]]', '["..#","#."]', '["..#","#.\N{ROBOT FACE}"]', '{"a":{"b":[1]}}', "[null,null]", "[true]"),
)
NO_JSON: tuple[str, ...] = (
    *("NaN", "Infinity", "-Infinity", "1e999", "-1e999", "01", "+1", ".5", "1.", "0x1", "'left'", "True"),
    *('"\\ud800"', '"\\x41"', '"a', '"\n"', "[1,]", "{,}", "/* no */ 1", "undefined", "1 2", "[1 2]", "nul"),
)


def option_line(generator: random.Random) -> list[bytes]:
    """Return the arguments of a solver; nearly half of them are right."""
    words: list[bytes] = []
    for _ in range(generator.randint(0, 6)):
        words += _option(generator)
    small, caps = [word.encode() for word in SMALL], [word.encode() for word in CAPS]
    for limit in (b"--time", b"--period"):  # a plan takes the time that it is given
        if any(word.startswith(limit) for word in words):
            caps += [limit, b"0.01"]
    if generator.random() < 0.1:  # the value of the last option is missing
        return [*small, *caps, *words, generator.choice(list(VALUES)).encode()]
    return [*small, *words, *caps]


def _option(generator: random.Random) -> list[bytes]:
    if generator.random() < 0.2:
        return [generator.choice(TOGGLES).encode()]
    if generator.random() < 0.04:
        return [generator.choice(ODD_NAMES)]
    name = generator.choice(list(VALUES))
    is_odd = generator.random() < 0.12
    value = generator.choice(ODD) if is_odd else VALUES[name](generator).encode()
    if name in ("--json", "--param", "--world-param"):  # no files are written or looked for by chance
        value = VALUES[name](generator).encode()
    return [name.encode() + b"=" + value] if generator.random() < 0.3 else [name.encode(), value]


def param_file(generator: random.Random) -> bytes:
    """Return the content of a file for ``--param``; about a third of them are right."""
    kind = generator.random()
    if kind < 0.45:
        return _object(generator, odd=0.0 if generator.random() < 0.75 else 0.3)
    if kind < 0.8:
        return _mutated(generator, _object(generator, odd=0.05))
    if kind < 0.85:
        return generator.randbytes(generator.choice([1, 2, 10, 1000]))
    if kind < 0.9:
        return _deep(generator)
    if kind < 0.95:
        return (
            _object(generator, odd=0.1).decode().encode(generator.choice(["utf-16", "utf-32", "utf-8-sig"]))
        )
    return generator.choice(
        [b"", b" \n\t", b"\0", b"{", b"}", b"[]", b"1", b'"hearing"', b"{}", b"null", b"{}{}"]
    )


def _object(generator: random.Random, odd: float) -> bytes:
    members = []
    names = list(PARAMS)
    for _ in range(generator.randint(0, 8)):
        name = generator.choice(names)
        if generator.random() >= 0.05:
            names.remove(name)  # otherwise it may come again
        if generator.random() < odd / 2:
            name = generator.choice(["Hearing", "", "hearing ", "\N{ROBOT FACE}", "x" * 10000, "__proto__"])
        value = json.dumps(PARAMS[name](generator), ensure_ascii=False) if name in PARAMS else "0"
        if generator.random() < odd:
            value = generator.choice(ODD_VALUES if generator.random() < 0.6 else NO_JSON)
        members.append(f"{json.dumps(name)}: {value}")
        if not names:
            break
    return ("{" + ", ".join(members) + "}").encode()


def _mutated(generator: random.Random, text: bytes) -> bytes:
    changed = bytearray(text)
    for _ in range(generator.choice([1, 1, 1, 2, 5, 20])):
        at = generator.randrange(len(changed) + 1)
        what = generator.random()
        if what < 0.3:
            changed[at : at + generator.choice([1, 1, 2, 10])] = b""
        elif what < 0.6:
            changed[at:at] = generator.choice(
                [b"[", b"]", b"{", b"}", b'"', b",", b":", b"\\", b"-", b"e", b"0", b"\0"]
            )
        elif what < 0.8:
            changed[at:at] = generator.choice(
                [b"\xff", b"\xc3", b"\xed\xa0\x80", b"\xef\xbb\xbf", b"\x1b", b"\n"]
            )
        elif what < 0.9:
            changed[at:at] = changed[: generator.randrange(len(changed) + 1)]
        else:
            del changed[at:]
    return bytes(changed)


def _deep(generator: random.Random) -> bytes:
    depth = generator.choice([10, 99, 100, 101, 1000, 100_000])
    opening = generator.choice([b"[", b'{"a":', b'{"rocks":[', b"[[{}],"])
    closing = {b"[": b"]", b'{"a":': b"}", b'{"rocks":[': b"]}", b"[[{}],": b"]"}[opening]
    text = opening * depth + b"1" + closing * (depth if generator.random() < 0.5 else 0)
    return b'{"rocks": ' + text + b"}" if generator.random() < 0.5 else text
