# SPDX-License-Identifier: Apache-2.0
"""Samples of exact posteriors have their values in proportion."""

from __future__ import annotations

import numpy as np

from hypgen.dsl.interpret.factor_samples import factor_samples
from hypgen.dsl.load import load
from hypgen.dsl.messages.source import Source

MODEL = """model Two
type Side = -1 .. 1
type Ball = 0 .. 1
enum Act { wait }
discount 0.9
action act: Act
element ball[b in Ball] {
  hidden side: Side
  hidden ripe: bool
  init side ~ uniform(Side)
  init ripe ~ bernoulli(0.5)
  side' = side
  ripe' = ripe
}
observe seen: bool[Ball] ~ [b in Ball: noisy(ball[b].ripe', 0.9)]
reward r = if ball[0].side == 1 then 1 else 0
"""


def test_each_joint_value_has_its_share() -> None:
    model = load("two.pomdp", given=Source("two.pomdp", MODEL)).model
    posterior = {"ball": [[0.5, 0, 0, 0.25, 0, 0.25], [0, 0, 1, 0, 0, 0]]}
    sampled = factor_samples(model, posterior, 100)
    side, ripe = sampled["ball.side"], sampled["ball.ripe"]
    assert side.shape == ripe.shape == (100, 2)
    pairs = {(s, r): int(((side[:, 0] == s) & (ripe[:, 0] == r)).sum()) for s in (-1, 0, 1) for r in (0, 1)}
    assert pairs == {(-1, 0): 50, (-1, 1): 0, (0, 0): 0, (0, 1): 25, (1, 0): 0, (1, 1): 25}
    assert np.all(side[:, 1] == 0)
    assert not ripe[:, 1].any()


def test_what_has_no_posterior_is_not_sampled() -> None:
    model = load("two.pomdp", given=Source("two.pomdp", MODEL)).model
    assert factor_samples(model, {}, 10) == {}
