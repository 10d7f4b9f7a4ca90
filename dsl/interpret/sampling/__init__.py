# SPDX-License-Identifier: Apache-2.0
"""``hypgen check --samples``: what only running a model finds.

Takes an ``ir.Model``. Gives ``Finding`` values: the mistake, its place, and the state that shows it.
"""
